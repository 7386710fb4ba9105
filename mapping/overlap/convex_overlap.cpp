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

/// A hull's corners around a box's centre, as libccd sees them.
struct HullBody {
  std::span<const Eigen::Vector3d> corners;
  Eigen::Vector3d origin;
};

Eigen::Vector3d farthest(const HullBody& body, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d* best = &body.corners.front();
  for (const Eigen::Vector3d& corner : body.corners) {
    if (direction.dot(corner) > direction.dot(*best)) best = &corner;
  }
  return *best - body.origin;
}

void hull_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* corner) {
  const Eigen::Vector3d p =
      farthest(*static_cast<const HullBody*>(object),
               {ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction)});
  ccdVec3Set(corner, p.x(), p.y(), p.z());
}

/// A box around the origin.
struct CentredBox {
  Eigen::Vector3d half_extents;
  mutable Eigen::Vector3d direction = Eigen::Vector3d::Zero();
};

void box_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* corner) {
  const CentredBox& box = *static_cast<const CentredBox*>(object);
  box.direction = {ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction)};
  const auto side = [&](int axis) {
    return box.direction(axis) < 0.0 ? -box.half_extents(axis) : box.half_extents(axis);
  };
  ccdVec3Set(corner, side(0), side(1), side(2));
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

HullTest::HullTest(std::span<const Eigen::Vector3d> corners) : corners_(corners) {
  for (const Eigen::Vector3d& corner : corners) reach_m_ = std::max(reach_m_, corner.norm());
}

HullTest::Plane HullTest::plane_across(const Eigen::Vector3d& direction) const {
  Plane plane{direction.normalized(), std::numeric_limits<double>::infinity()};
  for (const Eigen::Vector3d& corner : corners_)
    plane.offset_m = std::min(plane.offset_m, plane.direction.dot(corner));
  return plane;
}

bool HullTest::proves(const Plane& plane, const Eigen::AlignedBox3d& box) const {
  const Eigen::Vector3d centre = box.center();
  const Eigen::Vector3d half = 0.5 * box.sizes();
  const double gap =
      plane.offset_m - plane.direction.dot(centre) - plane.direction.cwiseAbs().dot(half);
  return gap > kRounding * (reach_m_ + centre.cwiseAbs().sum() + half.sum());
}

bool HullTest::is_disjoint_from(const Eigen::AlignedBox3d& box) {
  if (corners_.empty() || box.isEmpty()) return true;
  for (std::size_t i = 0; i < num_planes_; ++i) {
    if (proves(planes_[i], box)) return true;
  }
  const HullBody hull{corners_, box.center()};
  const CentredBox centred{0.5 * box.sizes()};
  ccd_t search;
  CCD_INIT(&search);
  search.support1 = hull_support;
  search.support2 = box_support;
  search.max_iterations = kMaxIterations;
  if (ccdGJKIntersect(&hull, &centred, &search) != 0) return false;
  // The last direction asked for is a hint, in either sense.
  if (!(centred.direction.norm() > 0)) return false;
  for (const double sign : {1.0, -1.0}) {
    const Plane plane = plane_across(sign * centred.direction);
    if (!proves(plane, box)) continue;
    planes_[next_plane_] = plane;
    next_plane_ = (next_plane_ + 1) % planes_.size();
    num_planes_ = std::min(num_planes_ + 1, planes_.size());
    return true;
  }
  return false;
}

}  // namespace cloister
