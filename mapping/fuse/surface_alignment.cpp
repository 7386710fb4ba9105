#include "mapping/fuse/surface_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace cloister {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A plane needs so many faces of voxels, is so thin and at least so wide (variances, voxels^2; a layer of voxels across a
// block has up to 1/4 across and 5 along).
constexpr int kMinFaces = 10;
constexpr double kMaxVarianceAcross = 0.5;
constexpr double kMinVarianceAlong = 1.5;
// Planes of both are of one surface when they look the same way.
constexpr double kMinCosine = 0.92;
// Of the smaller one's planes so many tell.
constexpr std::size_t kMaxPlanes = 3'000;
// Below, chance has brought the planes together.
constexpr std::size_t kMinPlanes = 40;
constexpr int kRounds = 12;
// How far apart two planes count half, as the search goes on.
constexpr double kFirstScaleM = 0.3, kLastScaleM = 0.065, kScaleStep = 0.8;
// How well the mean of all planes is known: a direction that one plane in four hundred tells is known as well as a graph
// of 0.2 m tells it.
constexpr double kMeanSigmaM = 0.01;
// Less is as good as none: submaps that no correction has moved apart keep their common grid.
constexpr double kMinShiftVox = 0.1;
// What is left of the disagreement must be less than this, for the planes to be believed rather than the graph.
constexpr double kMaxLeft = 0.8;

struct Plane {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // metres
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// The plane of the surface in a block, if there is one: of the faces between occupied and free voxels. What is behind a
/// surface is never cleared, so that walls grow thick to the back; their fronts stay.
std::optional<Plane> plane_of(const VoxelStore& store, const Volume& volume,
                              const BlockCoord& coord, double voxel_m) {
  const BlockView view = volume.view(store, coord);
  if (view.block == nullptr) return std::nullopt;
  int count = 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (view.block->voxels[i] <= 0) continue;
    const VoxelCoord in_block(i & 7, i >> 3 & 7, i >> 6);
    for (int face = 0; face < 6; ++face) {
      const VoxelCoord step = (face & 1 ? 1 : -1) * VoxelCoord::Unit(face >> 1);
      const VoxelCoord next = in_block + step;
      const bool is_within = (next.array() >= 0).all() && (next.array() < kBlockEdge).all();
      const LogOdds value = is_within ? view.block->voxels[index_in_block(next)]
                                      : volume.at(store, coord * kBlockEdge + next);
      if (value >= 0) continue;
      const Eigen::Vector3f p = in_block.cast<float>() + 0.5f * step.cast<float>();
      ++count;
      sum += p;
      squares += p * p.transpose();
    }
  }
  if (count < kMinFaces) return std::nullopt;
  const Eigen::Vector3d middle = sum.cast<double>() / count;
  const Eigen::Matrix3d covariance =
      squares.cast<double>() / count - middle * middle.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  if (axes.eigenvalues()[0] > kMaxVarianceAcross || axes.eigenvalues()[1] < kMinVarianceAlong)
    return std::nullopt;
  return Plane{
      (coord.cast<double>() * kBlockEdge + middle + Eigen::Vector3d::Constant(0.5)) * voxel_m,
      axes.eigenvectors().col(0)};
}

/// The planes of a volume, each made when it is first asked for.
class Planes {
 public:
  Planes(const VoxelStore& store, const Volume& volume, double voxel_m)
      : store_(store), volume_(volume), voxel_m_(voxel_m) {}

  /// The nearest plane across that looks the same way, around a place.
  [[nodiscard]] const Plane* nearest(const Plane& plane) {
    const double block_m = kBlockEdge * voxel_m_;
    const BlockCoord under = (plane.middle / block_m).array().floor().matrix().cast<int>();
    const Plane* best = nullptr;
    double best_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 7; ++i) {
      BlockCoord coord = under;
      if (i > 0) coord[(i - 1) / 2] += (i & 1) != 0 ? 1 : -1;
      const Plane* here = at(coord);
      if (here == nullptr || std::abs(here->normal.dot(plane.normal)) < kMinCosine) continue;
      const double across_m = std::abs(here->normal.dot(plane.middle - here->middle));
      if (across_m >= best_m) continue;
      best = here;
      best_m = across_m;
    }
    return best;
  }

 private:
  [[nodiscard]] const Plane* at(const BlockCoord& coord) {
    const auto [item, is_new] = planes_.try_emplace({coord.x(), coord.y(), coord.z()});
    if (is_new) item->second = plane_of(store_, volume_, coord, voxel_m_);
    return item->second ? &*item->second : nullptr;
  }

  const VoxelStore& store_;
  const Volume& volume_;
  double voxel_m_;
  std::map<std::array<int, 3>, std::optional<Plane>> planes_;
};

Plane moved(const Pose& T, const Plane& plane) {
  return {T * plane.middle, T.linear() * plane.normal};
}

/// A small movement around a place: turn (rotation vector) and shift.
Pose movement(const Vector6d& x, const Eigen::Vector3d& around) {
  Pose T = Pose::Identity();
  // Small turns: half the rotation vector is the quaternion's, without a sine that libraries round as they like.
  T.linear() = Eigen::Quaterniond(1, x[0] / 2, x[1] / 2, x[2] / 2).normalized().toRotationMatrix();
  T.translation() = around + x.tail<3>() - T.linear() * around;
  return T;
}

double penalty(double across_m, double scale_m) {
  const double square = across_m * across_m / (scale_m * scale_m);
  return square / (1 + square);
}

/// How badly the planes fit; one that has no counterpart counts as one that is far from it.
double misfit(const std::vector<Plane>& planes_a, Planes& planes_b, const Pose& T_b_a) {
  double sum = 0;
  for (const Plane& plane_a : planes_a) {
    const Plane plane = moved(T_b_a, plane_a);
    const Plane* other = planes_b.nearest(plane);
    sum += other != nullptr
               ? penalty(other->normal.dot(plane.middle - other->middle), kLastScaleM)
               : 1;
  }
  return sum / static_cast<double>(planes_a.size());
}

/// The planes of a for which b has a counterpart where the graph has it, thinned.
std::vector<Plane> shared_planes(const VoxelStore& store, const Volume& a, Planes& planes_b,
                                 const Pose& T_b_a, double voxel_m) {
  // A volume has its blocks in the order in which they came; sums must not depend on it.
  std::vector<std::array<int, 3>> coords;
  a.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    if (view.block != nullptr) coords.push_back({coord.x(), coord.y(), coord.z()});
  });
  std::sort(coords.begin(), coords.end());
  std::vector<Plane> shared;
  for (const auto& [x, y, z] : coords) {
    const auto plane = plane_of(store, a, {x, y, z}, voxel_m);
    if (plane && planes_b.nearest(moved(T_b_a, *plane)) != nullptr) shared.push_back(*plane);
  }
  const std::size_t stride = shared.size() / kMaxPlanes + 1;
  std::size_t num_kept = 0;
  for (std::size_t i = 0; i < shared.size(); i += stride) shared[num_kept++] = shared[i];
  shared.resize(num_kept);
  return shared;
}

/// The movement around a place that brings planes together, as far as the graph's word lets it: Gauss and Newton's steps,
/// each with counterparts and weights of its own.
Vector6d fit(const std::vector<Plane>& planes_a, Planes& planes_b, const Pose& T_b_a,
             const Eigen::Vector3d& around_b, double sigma_m) {
  Vector6d word;  // the graph's, as information
  word << Eigen::Vector3d::Constant(kLeverM * kLeverM / (sigma_m * sigma_m)),
      Eigen::Vector3d::Constant(1 / (sigma_m * sigma_m));
  const double share = 1 / (kMeanSigmaM * kMeanSigmaM) / static_cast<double>(planes_a.size());
  Vector6d x = Vector6d::Zero();
  double scale_m = kFirstScaleM;
  for (int round = 0; round < kRounds; ++round) {
    const Pose T = movement(x, around_b) * T_b_a;
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (const Plane& plane_a : planes_a) {
      const Plane plane = moved(T, plane_a);
      const Plane* other = planes_b.nearest(plane);
      if (other == nullptr) continue;
      const double across_m = other->normal.dot(plane.middle - other->middle);
      const double damped = 1 + across_m * across_m / (scale_m * scale_m);
      const double weight = 1 / (damped * damped);
      Vector6d J;
      J << (plane.middle - around_b).cross(other->normal), other->normal;
      H += weight * J * J.transpose();
      g += weight * across_m * J;
    }
    H *= share;
    g *= share;
    H.diagonal() += word;
    g += word.cwiseProduct(x);
    x -= H.ldlt().solve(g);
    scale_m = std::max(kScaleStep * scale_m, kLastScaleM);
  }
  return x;
}

}  // namespace

SurfaceAlignment align_surfaces(const VoxelStore& store, const Volume& a, const Volume& b,
                                const Pose& T_b_a, double sigma_m, double voxel_size_m) {
  if (a.num_blocks() > b.num_blocks()) {
    SurfaceAlignment reversed =
        align_surfaces(store, b, a, T_b_a.inverse(), sigma_m, voxel_size_m);
    reversed.T_b_a = reversed.shift_m > 0 ? Pose(reversed.T_b_a.inverse()) : T_b_a;
    return reversed;
  }
  Planes planes_b(store, b, voxel_size_m);
  const std::vector<Plane> planes_a = shared_planes(store, a, planes_b, T_b_a, voxel_size_m);
  if (planes_a.size() < kMinPlanes) return {T_b_a, 0};
  Eigen::Vector3d middle_b = Eigen::Vector3d::Zero();
  for (const Plane& plane : planes_a) middle_b += T_b_a * plane.middle;
  middle_b /= static_cast<double>(planes_a.size());

  const Vector6d x = fit(planes_a, planes_b, T_b_a, middle_b, sigma_m);
  const double shift_m = x.tail<3>().norm() + kLeverM * x.head<3>().norm();
  // Written so that no number fails as well.
  if (!(shift_m >= kMinShiftVox * voxel_size_m && shift_m <= 2 * sigma_m)) return {T_b_a, 0};
  const Pose T_aligned = movement(x, middle_b) * T_b_a;
  if (misfit(planes_a, planes_b, T_aligned) > kMaxLeft * misfit(planes_a, planes_b, T_b_a))
    return {T_b_a, 0};
  return {T_aligned, shift_m};
}

}  // namespace cloister
