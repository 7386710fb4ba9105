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

}  // namespace cloister
