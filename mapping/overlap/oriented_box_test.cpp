#include "mapping/overlap/oriented_box.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

using Eigen::AlignedBox3d;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

}  // namespace

TEST_CASE("the bounds of an oriented box are those of its eight corners") {
  constexpr unsigned seed = 31;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-10.0, 10.0);
  for (int n = 0; n < 100; ++n) {
    AlignedBox3d bounds_S;
    for (int corner = 0; corner < 2; ++corner) {
      bounds_S.extend(Vector3d(uniform(random), uniform(random), uniform(random)));
    }
    const Pose T_M_S =
        make_pose({uniform(random), uniform(random), uniform(random)},
                  Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random)));
    AlignedBox3d expected;
    for (int corner = 0; corner < 8; ++corner) {
      expected.extend(T_M_S * bounds_S.corner(static_cast<AlignedBox3d::CornerType>(corner)));
    }
    const AlignedBox3d bounds_M = bounds_in_map(oriented_box(bounds_S, T_M_S));
    CHECK((bounds_M.min() - expected.min()).norm() < 1e-12);
    CHECK((bounds_M.max() - expected.max()).norm() < 1e-12);
  }
}

TEST_CASE("a cube turned by an eighth has bounds wider by the root of two") {
  const AlignedBox3d bounds_S(Vector3d(1.0, 1.0, 1.0), Vector3d(3.0, 3.0, 3.0));
  const Pose T_M_S = make_pose({5.0, 0.0, 0.0},
                               Quaterniond(AngleAxisd(std::numbers::pi / 4.0, Vector3d::UnitZ())));
  const AlignedBox3d bounds_M = bounds_in_map(oriented_box(bounds_S, T_M_S));
  CHECK(bounds_M.sizes().isApprox(Vector3d(std::sqrt(8.0), std::sqrt(8.0), 2.0)));
  CHECK(bounds_M.center().isApprox(Vector3d(5.0, std::sqrt(8.0), 2.0)));
}

TEST_CASE("overlap ratios are the common volume over each volume") {
  const AlignedBox3d a(Vector3d(0.0, 0.0, 0.0), Vector3d(4.0, 2.0, 1.0));
  SUBCASE("partly common") {
    const OverlapRatios ratios =
        aabb_overlap_ratios(a, {Vector3d(3.0, 1.0, 0.0), Vector3d(5.0, 2.0, 4.0)});
    CHECK(ratios.a == doctest::Approx(1.0 / 8.0));
    CHECK(ratios.b == doctest::Approx(1.0 / 8.0));
  }
  SUBCASE("nested") {
    const OverlapRatios ratios =
        aabb_overlap_ratios(a, {Vector3d(1.0, 0.5, 0.25), Vector3d(2.0, 1.5, 0.75)});
    CHECK(ratios.a == doctest::Approx(0.5 / 8.0));
    CHECK(ratios.b == 1.0);
  }
  SUBCASE("identical") {
    const OverlapRatios ratios = aabb_overlap_ratios(a, a);
    CHECK(ratios.a == 1.0);
    CHECK(ratios.b == 1.0);
  }
  SUBCASE("touching at a face") {
    const OverlapRatios ratios =
        aabb_overlap_ratios(a, {Vector3d(4.0, 0.0, 0.0), Vector3d(5.0, 2.0, 1.0)});
    CHECK(ratios.a == 0.0);
    CHECK(ratios.b == 0.0);
  }
  SUBCASE("apart along one axis") {
    const OverlapRatios ratios =
        aabb_overlap_ratios(a, {Vector3d(0.0, 0.0, 3.0), Vector3d(4.0, 2.0, 5.0)});
    CHECK(ratios.a == 0.0);
    CHECK(ratios.b == 0.0);
  }
  SUBCASE("a flat box counts by its area") {
    const OverlapRatios ratios =
        aabb_overlap_ratios(a, {Vector3d(0.0, 0.0, 0.5), Vector3d(8.0, 2.0, 0.5)});
    CHECK(ratios.a == 0.0);
    CHECK(ratios.b == doctest::Approx(0.5));
  }
  SUBCASE("a point inside is common as a whole") {
    CHECK(aabb_overlap_ratios(a, AlignedBox3d(Vector3d(1.0, 1.0, 0.5))).b == 1.0);
    CHECK(aabb_overlap_ratios(a, AlignedBox3d(Vector3d(1.0, 1.0, 1.5))).b == 0.0);
  }
  SUBCASE("an empty box overlaps nothing") {
    const OverlapRatios ratios = aabb_overlap_ratios(a, AlignedBox3d());
    CHECK(ratios.a == 0.0);
    CHECK(ratios.b == 0.0);
  }
}

}  // namespace cloister
