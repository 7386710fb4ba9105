#pragma once

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

/// The same for the convex hull of some corners and a box along the axes of their frame.
/// @param corners  in any order, inner points allowed, none: everything is apart from nothing
[[nodiscard]] bool hull_and_box_disjoint(std::span<const Eigen::Vector3d> corners,
                                         const Eigen::AlignedBox3d& box);

}  // namespace cloister
