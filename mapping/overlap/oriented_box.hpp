#pragma once

#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"

namespace cloister {

/// A box in M whose edges run along a submap's axes. Threads: plain data and pure functions. Real-time: no allocation.
struct OrientedBox {
  Eigen::Vector3d centre_M = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector3d half_extents_m =
      Eigen::Vector3d::Zero();  ///< along the columns of R_M_S; zero is a flat box
  Eigen::Matrix3d R_M_S = Eigen::Matrix3d::Identity();  ///< columns: the box's axes in M
};

/// The box of a submap: its grid-aligned bounds where its pose puts them.
/// @param bounds_S  not empty, metres
[[nodiscard]] OrientedBox oriented_box(const Eigen::AlignedBox3d& bounds_S, const Pose& T_M_S);

/// The smallest box along M's axes that holds the oriented one; larger the more S is rotated against M.
[[nodiscard]] Eigen::AlignedBox3d bounds_in_map(const OrientedBox& box);

/// Shares of two boxes' volumes that lie in both: R_aabb of each (paper, section III-B), 0 to 1.
struct OverlapRatios {
  double a = 0.0;
  double b = 0.0;
};

/// Ratios of two boxes along the same axes. A flat box counts by its area, a thin one by its length, a point as one.
[[nodiscard]] OverlapRatios aabb_overlap_ratios(const Eigen::AlignedBox3d& a,
                                                const Eigen::AlignedBox3d& b);

}  // namespace cloister
