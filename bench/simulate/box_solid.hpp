#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "bench/simulate/triangle_mesh.hpp"

namespace cloister {

/// An axis-aligned solid block. Whole millimetres, so that blocks meant to touch do so exactly.
struct BoxSolid {
  Eigen::Vector3i min_mm = Eigen::Vector3i::Zero();
  Eigen::Vector3i max_mm = Eigen::Vector3i::Zero();
  float albedo = 0.5F;

  /// From corners in metres, rounded to millimetres; the corners may come in any order.
  [[nodiscard]] static BoxSolid from_corners_m(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                               float albedo);

  [[nodiscard]] Eigen::Vector3d min_m() const { return min_mm.cast<double>() * 1e-3; }
  [[nodiscard]] Eigen::Vector3d max_m() const { return max_mm.cast<double>() * 1e-3; }
  [[nodiscard]] bool contains(const Eigen::Vector3d& point_m) const;
  /// Distance from a point to the block, 0 inside.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& point_m) const;
};

/// The outer surface of the union of the blocks: every face without the parts that other blocks
/// cover, so that no triangle lies inside a solid and none lies twice in one place. Exact;
/// O(blocks^2).
[[nodiscard]] TriangleMesh union_surface(std::span<const BoxSolid> boxes);

}  // namespace cloister
