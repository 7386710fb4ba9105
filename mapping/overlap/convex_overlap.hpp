#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "mapping/overlap/oriented_box.hpp"

namespace cloister {

/// A sound early "no" for pairs of submaps whose axis-aligned boxes meet although they themselves do not.
///
/// GJK (libccd) looks for a direction in which the boxes lie apart. Its answer is only a hint, since it says "apart"
/// also when it ran out of iterations: the last direction it tried is checked here, by the boxes' widths along it.
/// @return true only when the boxes have no point in common; false when they have, touch, come closer than rounding
///         can tell, hold a number that is not finite, or when the search ended without a proof. The same for (a, b)
///         and (b, a)
/// Threads: pure function. Real-time: no allocation, at most a fixed number of iterations.
[[nodiscard]] bool boxes_disjoint(const OrientedBox& a, const OrientedBox& b);

/// The same for the convex hull of some corners and boxes along the axes of their frame, many of them: a direction that
/// has proved one box apart proves most of its neighbours apart, without another search.
///
/// Threads: one at a time. Real-time: no allocation, at most a fixed number of iterations.
class HullTest {
 public:
  /// @param corners  in any order, inner points allowed; they must outlive the test. None: apart from everything
  explicit HullTest(std::span<const Eigen::Vector3d> corners);

  [[nodiscard]] bool is_disjoint_from(const Eigen::AlignedBox3d& box);

 private:
  /// All corners lie at or beyond `offset_m` along the direction.
  struct Plane {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double offset_m = 0;
  };

  [[nodiscard]] bool proves(const Plane& plane, const Eigen::AlignedBox3d& box) const;
  [[nodiscard]] Plane plane_across(const Eigen::Vector3d& direction) const;

  std::span<const Eigen::Vector3d> corners_;
  double reach_m_ = 0;  ///< of the corners from their frame's origin
  std::array<Plane, 8> planes_;
  std::size_t num_planes_ = 0;
  std::size_t next_plane_ = 0;
};

}  // namespace cloister
