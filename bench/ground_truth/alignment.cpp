#include "bench/ground_truth/alignment.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace cloister {

Alignment align(std::span<const StampedPose> T_M_L, const std::vector<StampedPose>& T_W_L) {
  const auto count = static_cast<Eigen::Index>(T_M_L.size());
  Eigen::Matrix3Xd points_M(3, 4 * count);
  Eigen::Matrix3Xd points_W(3, 4 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const StampedPose& estimate = T_M_L[static_cast<std::size_t>(k)];
    // The columns of a pose's matrix are its axes and its origin.
    const auto put = [k](const Pose& pose, Eigen::Matrix3Xd* points) {
      points->col(4 * k) = pose.translation();
      points->middleCols<3>(4 * k + 1) = pose.linear().colwise() + pose.translation();
    };
    put(estimate.pose, &points_M);
    put(pose_at(T_W_L, estimate.stamp), &points_W);
  }
  Alignment alignment;
  alignment.T_W_M.matrix() = Eigen::umeyama(points_M, points_W, false);
  double squares = 0.0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double error = (alignment.T_W_M * points_M.col(4 * k) - points_W.col(4 * k)).norm();
    squares += error * error;
    alignment.max_m = std::max(alignment.max_m, error);
  }
  alignment.rms_m = std::sqrt(squares / static_cast<double>(count));
  return alignment;
}

LocalAlignment::LocalAlignment(std::span<const StampedPose> T_M_L,
                               const std::vector<StampedPose>& T_W_L) {
  constexpr double kStep_m = 0.5;
  for (const StampedPose& estimate : T_M_L) {
    const Eigen::Vector3d at_M = estimate.pose.translation();
    if (!corrections_.empty() && (at_M - corrections_.back().at_M).norm() < kStep_m) continue;
    corrections_.push_back({at_M, pose_at(T_W_L, estimate.stamp) * estimate.pose.inverse()});
  }
}

Eigen::Vector3d LocalAlignment::to_world(const Eigen::Vector3d& p_M) const {
  constexpr double kSigma_m = 5.0;
  const auto square = [&](const Correction& c) { return (c.at_M - p_M).squaredNorm(); };
  const Correction& nearest = *std::min_element(
      corrections_.begin(), corrections_.end(),
      [&](const Correction& a, const Correction& b) { return square(a) < square(b); });
  const double least = square(nearest);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (const Correction& correction : corrections_) {
    const double weight = std::exp((least - square(correction)) / (2.0 * kSigma_m * kSigma_m));
    sum += weight * (correction.T_W_M * p_M);
    weights += weight;
  }
  return sum / weights;
}

}  // namespace cloister
