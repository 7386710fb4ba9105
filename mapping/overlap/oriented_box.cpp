#include "mapping/overlap/oriented_box.hpp"

#include <algorithm>

namespace cloister {
namespace {

/// Share of an edge that is common; an edge without length that touches the other box is common as a whole.
double share(double common_m, double length_m) {
  return length_m > 0.0 ? common_m / length_m : 1.0;
}

}  // namespace

OrientedBox oriented_box(const Eigen::AlignedBox3d& bounds_S, const Pose& T_M_S) {
  return {T_M_S * bounds_S.center(), 0.5 * bounds_S.sizes(), T_M_S.linear()};
}

Eigen::AlignedBox3d bounds_in_map(const OrientedBox& box) {
  const Eigen::Vector3d reach_m = box.R_M_S.cwiseAbs() * box.half_extents_m;
  return {box.centre_M - reach_m, box.centre_M + reach_m};
}

OverlapRatios aabb_overlap_ratios(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  OverlapRatios ratios{1.0, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    const double common_m =
        std::min(a.max()(axis), b.max()(axis)) - std::max(a.min()(axis), b.min()(axis));
    if (!(common_m >= 0.0)) return {};
    ratios.a *= share(common_m, a.sizes()(axis));
    ratios.b *= share(common_m, b.sizes()(axis));
  }
  return ratios;
}

}  // namespace cloister
