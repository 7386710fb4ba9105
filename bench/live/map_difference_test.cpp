#include "bench/live/map_difference.hpp"

#include <doctest/doctest.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"

namespace cloister {
namespace {

TEST_CASE(
    "equal maps do not differ, whether they say it by nodes or by voxels, and wherever their "
    "submaps lie") {
  MapBuilder a, b;
  Submap& of_a = a.add_submap(3);
  Submap& of_b = b.add_submap(3, pose_of(1, 2, 3, 0.5));
  a.set_coarse(of_a, {0, 0, 0}, -5, 0b101);
  b.set_plain(of_b, {0, 0, 0}, -7, 0b101);
  a.set_voxel(of_a, {20, 0, 0}, 9);
  b.set_voxel(of_b, {20, 0, 0}, 4);
  const MapDifference difference = compare_maps(a.view(), b.view());
  CHECK(difference.observed() == 2 * 64 + 1);
  CHECK(difference.differing() == 0);
  CHECK(difference.share() == 0);
}

TEST_CASE("a voxel differs where one map calls it occupied and the other free or unknown") {
  MapBuilder a, b;
  Submap& of_a = a.add_submap(1);
  Submap& of_b = b.add_submap(1);
  a.set_coarse(of_a, {0, 0, 0}, -5);
  b.set_plain(of_b, {0, 0, 0}, -5, kAllOctants);
  b.set_voxel(of_b, {1, 2, 3}, 6);   // free in a
  b.set_voxel(of_b, {0, 0, 40}, 6);  // in a block that a does not have
  a.set_voxel(of_a, {0, 80, 0}, 6);  // in a block that b does not have
  for (const auto& difference :
       {compare_maps(a.view(), b.view()), compare_maps(b.view(), a.view())}) {
    REQUIRE(difference.submaps.size() == 1);
    CHECK(difference.submaps[0].is_in_both);
    CHECK(difference.observed() == 512 + 2);
    CHECK(difference.differing() == 3);
    CHECK(difference.share() == doctest::Approx(3.0 / 514.0));
  }
}

TEST_CASE("a submap that only one map has differs as a whole") {
  MapBuilder a, b;
  a.set_voxel(a.add_submap(1), {0, 0, 0}, 6);
  Submap& of_b = b.add_submap(1);
  b.set_voxel(of_b, {0, 0, 0}, 6);
  b.set_coarse(b.add_submap(2), {4, 4, 4}, -5);
  const MapDifference difference = compare_maps(a.view(), b.view());
  REQUIRE(difference.submaps.size() == 2);
  CHECK(difference.submaps[0].differing == 0);
  CHECK_FALSE(difference.submaps[1].is_in_both);
  CHECK(difference.submaps[1].differing == 512);
  CHECK(difference.observed() == 513);
}

}  // namespace
}  // namespace cloister
