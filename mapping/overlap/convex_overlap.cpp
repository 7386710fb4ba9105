#include "mapping/overlap/convex_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <ccd/ccd.h>

namespace cloister {
namespace {

/// Boxes that are clearly apart or clearly not need fewer than ten; libccd's default is no limit at all.
constexpr unsigned long kMaxIterations = 50;

/// Of the lengths that enter a gap: well above the rounding of the dozen operations that make it.
constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();

/// One of the two bodies as libccd sees it: its centre is taken relative to the first box, so that a map far from
/// its origin costs no digits.
struct Body {
  const OrientedBox& box;
  Eigen::Vector3d centre_m;
  mutable Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();  ///< the last one a support point was asked for
};

/// The box's farthest corner in a direction.
void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* corner) {
  const Body& body = *static_cast<const Body*>(object);
  body.direction = {ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction)};
  Eigen::Vector3d p = body.centre_m;
  for (int axis = 0; axis < 3; ++axis) {
    const auto edge = body.box.R_M_S.col(axis);
    p += (edge.dot(body.direction) < 0.0 ? -body.box.half_extents_m(axis)
                                         : body.box.half_extents_m(axis)) *
         edge;
  }
  ccdVec3Set(corner, p.x(), p.y(), p.z());
}

/// Half the box's width along a direction, times the direction's length.
double reach(const OrientedBox& box, const Eigen::Vector3d& direction) {
  return (box.R_M_S.transpose() * direction).cwiseAbs().dot(box.half_extents_m);
}

/// The proof: the plane across `direction` has one box on either side, with room for rounding.
bool separates(const Eigen::Vector3d& direction, const OrientedBox& a, const OrientedBox& b) {
  const double distance = std::abs(direction.dot(b.centre_M - a.centre_M));
  const double reaches = reach(a, direction) + reach(b, direction);
  const double scale = direction.norm() * (a.centre_M.norm() + b.centre_M.norm() +
                                           a.half_extents_m.sum() + b.half_extents_m.sum());
  return distance - reaches > kRounding * scale;
}

bool is_finite(const OrientedBox& box) {
  return box.centre_M.allFinite() && box.half_extents_m.allFinite() && box.R_M_S.allFinite();
}

/// Any fixed order of two boxes: by all their numbers.
bool comes_before(const OrientedBox& a, const OrientedBox& b) {
  const auto before = [](const auto& x, const auto& y) {
    return std::lexicographical_compare(x.data(), x.data() + x.size(), y.data(),
                                        y.data() + y.size());
  };
  if (a.centre_M != b.centre_M) return before(a.centre_M, b.centre_M);
  if (a.half_extents_m != b.half_extents_m) return before(a.half_extents_m, b.half_extents_m);
  return before(a.R_M_S, b.R_M_S);
}

}  // namespace

bool boxes_disjoint(const OrientedBox& a, const OrientedBox& b) {
  if (!is_finite(a) || !is_finite(b)) return false;
  const auto& [first, second] = comes_before(b, a) ? std::tie(b, a) : std::tie(a, b);
  const Body body_1{first, Eigen::Vector3d::Zero()};
  const Body body_2{second, second.centre_M - first.centre_M};

  ccd_t search;
  CCD_INIT(&search);
  search.support1 = support;
  search.support2 = support;
  search.max_iterations = kMaxIterations;
  // GJK alone of libccd's searches neither allocates nor ignores the limit.
  const bool may_be_apart = ccdGJKIntersect(&body_1, &body_2, &search) == 0;
  return may_be_apart && separates(body_1.direction, first, second);
}

}  // namespace cloister
