#include "mapping/overlap/convex_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include "mapping/overlap/separating_axes_for_tests.hpp"

namespace cloister {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(random), uniform(random), uniform(random)};
}

Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

/// Answers for a pair in both orders, which must agree.
bool disjoint_either_way(const OrientedBox& a, const OrientedBox& b) {
  const bool disjoint = boxes_disjoint(a, b);
  CHECK(boxes_disjoint(b, a) == disjoint);
  return disjoint;
}

/// Compares with the separating axes: never "disjoint" when they meet, always when a millimetre lies between them.
/// @return gaps of that size seen
int check_against_axes(const OrientedBox& a, const OrientedBox& b) {
  constexpr double kClear_m = 1e-3;
  const double gap_m = separating_axis_gap_m(a, b);
  const bool disjoint = disjoint_either_way(a, b);
  CAPTURE(gap_m);
  if (gap_m <= 0.0) CHECK_FALSE(disjoint);
  if (gap_m > kClear_m) CHECK(disjoint);
  return gap_m > kClear_m ? 1 : 0;
}

}  // namespace

TEST_CASE("random boxes are called disjoint exactly when an axis separates them") {
  constexpr unsigned seed = 41;
  CAPTURE(seed);
  std::mt19937 random(seed);
  int num_apart = 0;
  constexpr int kPairs = 20'000;
  for (int n = 0; n < kPairs; ++n) {
    CAPTURE(n);
    const OrientedBox a{random_vector(random, 5.0), random_vector(random, 5.0).cwiseAbs(),
                        random_rotation(random)};
    const OrientedBox b{random_vector(random, 5.0), random_vector(random, 5.0).cwiseAbs(),
                        random_rotation(random)};
    num_apart += check_against_axes(a, b);
  }
  CHECK(num_apart > kPairs / 5);
  CHECK(num_apart < kPairs * 4 / 5);
}

TEST_CASE(
    "nearly parallel and flat boxes are called disjoint exactly when an axis separates them") {
  constexpr unsigned seed = 42;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> coin(0, 1);
  for (int n = 0; n < 20'000; ++n) {
    CAPTURE(n);
    OrientedBox a{random_vector(random, 50.0), random_vector(random, 40.0).cwiseAbs(),
                  random_rotation(random)};
    OrientedBox b{random_vector(random, 50.0), random_vector(random, 40.0).cwiseAbs(), a.R_M_S};
    // Submaps begin parallel to M and are turned a little by corrections.
    b.R_M_S = AngleAxisd(1e-3, random_vector(random, 1.0).normalized()) * a.R_M_S;
    for (int axis = 0; axis < 3; ++axis) {
      if (coin(random) == 0) a.half_extents_m(axis) = 0.0;
      if (coin(random) == 0) b.half_extents_m(axis) = 0.0;
    }
    check_against_axes(a, b);
  }
}

TEST_CASE("boxes far from the map's origin keep their answer") {
  constexpr unsigned seed = 43;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const Vector3d far_M(5.0e5, 5.4e6, 300.0);
  for (int n = 0; n < 5'000; ++n) {
    CAPTURE(n);
    const OrientedBox a{far_M + random_vector(random, 20.0), random_vector(random, 15.0).cwiseAbs(),
                        random_rotation(random)};
    const OrientedBox b{far_M + random_vector(random, 20.0), random_vector(random, 15.0).cwiseAbs(),
                        random_rotation(random)};
    const double gap_m = separating_axis_gap_m(a, b);
    if (std::abs(gap_m) > 1e-3) CHECK(disjoint_either_way(a, b) == (gap_m > 0.0));
  }
}

TEST_CASE("a box is not disjoint from itself, from one inside it or from one it touches") {
  constexpr unsigned seed = 44;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (int n = 0; n < 1'000; ++n) {
    CAPTURE(n);
    const Vector3d half_extents_m = Vector3d::Constant(0.1) + random_vector(random, 5.0).cwiseAbs();
    const OrientedBox box{random_vector(random, 8.0), half_extents_m, random_rotation(random)};
    CHECK_FALSE(disjoint_either_way(box, box));
    const OrientedBox inner{box.centre_M, 0.05 * Vector3d::Ones(), random_rotation(random)};
    CHECK_FALSE(disjoint_either_way(box, inner));
    for (int axis = 0; axis < 3; ++axis) {
      OrientedBox neighbour = box;
      neighbour.centre_M += 2.0 * box.half_extents_m(axis) * box.R_M_S.col(axis);
      CHECK_FALSE(disjoint_either_way(box, neighbour));
      neighbour.centre_M += 1e-3 * box.R_M_S.col(axis);
      CHECK(disjoint_either_way(box, neighbour));
    }
  }
}

TEST_CASE("boxes on a grid that share a corner, an edge or a face are not disjoint") {
  const OrientedBox unit{Vector3d(0.5, 0.5, 0.5), Vector3d(0.5, 0.5, 0.5), Matrix3d::Identity()};
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        OrientedBox other = unit;
        other.centre_M += Vector3d(x, y, z);
        CHECK_FALSE(disjoint_either_way(unit, other));
      }
    }
  }
}

TEST_CASE("two boxes turned by an eighth are disjoint although their bounds in the map overlap") {
  const Matrix3d turn = AngleAxisd(std::numbers::pi / 4.0, Vector3d::UnitZ()).toRotationMatrix();
  const OrientedBox corridor{Vector3d::Zero(), Vector3d(20.0, 1.0, 1.5), turn};
  OrientedBox parallel = corridor;
  parallel.centre_M += 4.0 * turn.col(1);
  const OverlapRatios ratios =
      aabb_overlap_ratios(bounds_in_map(corridor), bounds_in_map(parallel));
  CHECK(ratios.a > 0.7);
  CHECK(ratios.b > 0.7);
  CHECK(disjoint_either_way(corridor, parallel));
}

TEST_CASE("points are disjoint unless they coincide") {
  const OrientedBox point{Vector3d(1.0, 2.0, 3.0), Vector3d::Zero(), Matrix3d::Identity()};
  OrientedBox other = point;
  CHECK_FALSE(disjoint_either_way(point, other));
  other.centre_M.x() += 1e-3;
  CHECK(disjoint_either_way(point, other));
}

TEST_CASE("a box that holds a number that is not finite is never called disjoint") {
  const OrientedBox box{Vector3d::Zero(), Vector3d::Ones(), Matrix3d::Identity()};
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    OrientedBox other = box;
    other.centre_M.x() = bad;
    CHECK_FALSE(disjoint_either_way(box, other));
    other = box;
    other.half_extents_m.y() = bad;
    CHECK_FALSE(disjoint_either_way(box, other));
  }
}

}  // namespace cloister
