#include "firmware_interface/map/map_query.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include <doctest/doctest.h>

#include "firmware_interface/map/combined_blocks.hpp"
#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/states_csv.hpp"

namespace cloister {
namespace {

/// Several random submaps that overlap around M's origin, given in any order.
void fill_overlapping(MapBuilder& map) {
  map.fill_randomly(map.add_submap(7, pose_of(0.13, -0.4, 0.2, 0.7, 0.05)), 3, 300);
  map.fill_randomly(map.add_submap(2), 4, 300);
  map.fill_randomly(map.add_submap(11, pose_of(-0.8, 1.6, 0, 0)), 5, 300);
  map.add_submap(1);
}

/// The definition, written down slowly.
QueryAnswer brute_force(const MapBuilder& map, const Eigen::Vector3d& p_M) {
  int sum = 0, strongest = 0;
  SubmapId submap_id = kNoSubmap;
  for (const Submap* submap : map.submap_ptrs) {
    const Eigen::Vector3d p_S = submap->T_M_S.inverse() * p_M / map.info.voxel_size_m;
    const int value = submap->volume.at(
        map.store, {static_cast<int>(std::floor(p_S.x())), static_cast<int>(std::floor(p_S.y())),
                    static_cast<int>(std::floor(p_S.z()))});
    if (value == 0) continue;
    sum += value;
    const bool is_stronger = submap_id == kNoSubmap || std::abs(value) > std::abs(strongest);
    const bool wins_tie = std::abs(value) == std::abs(strongest) && submap->id < submap_id;
    if (is_stronger || wins_tie) {
      strongest = value;
      submap_id = submap->id;
    }
  }
  if (submap_id == kNoSubmap) return {};
  if (sum == 0) sum = strongest > 0 ? 1 : -1;
  const auto log_odds = static_cast<LogOdds>(std::clamp(sum, -40, 70));
  return {log_odds < 0 ? VoxelState::kFree : VoxelState::kOccupied, log_odds, submap_id};
}

TEST_CASE("queries agree with the definition at random points") {
  MapBuilder map;
  fill_overlapping(map);
  const MapQuery query(map.view());
  const unsigned seed = 21;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> coordinate(-9, 9);
  int num_known = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Eigen::Vector3d p_M(coordinate(rng), coordinate(rng), coordinate(rng) / 3);
    const QueryAnswer answer = query.at(p_M);
    num_known += answer.state != VoxelState::kUnknown;
    REQUIRE(answer == brute_force(map, p_M));
  }
  CHECK(num_known > 20'000);
}

TEST_CASE("evidence of several submaps adds up, within the map's bounds") {
  MapBuilder map;
  const auto answer_for = [&](LogOdds first, LogOdds second) {
    for (SubmapId id = 0; id < 2; ++id) {
      Submap& submap =
          map.submaps.size() > static_cast<std::size_t>(id) ? map.submaps[id] : map.add_submap(id);
      map.set_voxel(submap, {0, 0, 0}, id == 0 ? first : second);
    }
    return MapQuery(map.view()).at({0.05, 0.05, 0.05});
  };
  CHECK(answer_for(10, 20) == QueryAnswer{VoxelState::kOccupied, 30, 1});
  CHECK(answer_for(-30, 20) == QueryAnswer{VoxelState::kFree, -10, 0});
  CHECK(answer_for(-30, -31) == QueryAnswer{VoxelState::kFree, -40, 1});
  CHECK(answer_for(60, 60) == QueryAnswer{VoxelState::kOccupied, 70, 0});
  CHECK(answer_for(0, -3) == QueryAnswer{VoxelState::kFree, -3, 1});
  CHECK(answer_for(0, 0) == QueryAnswer{});
  CHECK(answer_for(-5, 5) == QueryAnswer{VoxelState::kFree, -1, 0});
  CHECK(answer_for(5, -5) == QueryAnswer{VoxelState::kOccupied, 1, 0});
}

TEST_CASE("points that are far away or no points at all are unknown") {
  MapBuilder map;
  map.set_coarse(map.add_submap(0), {0, 0, 0}, -5);
  const MapQuery query(map.view());
  for (const double x : {-1e300, 1e300, 0.81, -1e-9, std::numeric_limits<double>::infinity(),
                         std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(query.at({x, 0.1, 0.1}) == QueryAnswer{});
  }
  CHECK(query.at({0.0, 0.0, 0.0}).state == VoxelState::kFree);
  CHECK(query.at({0.79, 0.79, 0.79}).state == VoxelState::kFree);
  CHECK(MapQuery(MapBuilder(0, 0).view()).at({0, 0, 0}) == QueryAnswer{});
}

TEST_CASE("states are written with coordinates and evidence that read back exactly") {
  MapBuilder map;
  Submap& submap = map.add_submap(4);
  map.set_voxel(submap, {0, 0, 0}, 17);
  map.set_voxel(submap, {-1, 0, 0}, -8);
  std::ostringstream out;
  const std::vector<Eigen::Vector3d> points = {
      {0.05, 0.05, 0.1 / 3}, {-0.05, 0.05, 0.05}, {1e6, -2.5, 0}};
  REQUIRE(write_states_csv(MapQuery(map.view()), points, out).has_value());
  CHECK(out.str() ==
        "x,y,z,state,log_odds,submap\n"
        "0.05,0.05,0.03333333333333333,occupied,0.85,4\n"
        "-0.05,0.05,0.05,free,-0.4,4\n"
        "1e+06,-2.5,0,unknown,0,-1\n");
  out.setstate(std::ios::badbit);
  CHECK(write_states_csv(MapQuery(map.view()), points, out).error().kind == ErrorKind::kResource);
}

TEST_CASE("the combined grid says at every voxel what a query at its centre says") {
  MapBuilder map;
  fill_overlapping(map);
  const MapQuery query(map.view());
  BlockCoord before(0, 0, -1000);
  std::size_t num_known = 0;
  REQUIRE(for_each_combined_block(map.view(), 1 << 15, [&](const CombinedBlock& block) {
    const bool is_sorted = std::tuple(before.z(), before.y(), before.x()) <
                           std::tuple(block.coord.z(), block.coord.y(), block.coord.x());
    CHECK(is_sorted);
    before = block.coord;
    for (int i = 0; i < kBlockVoxels; ++i) {
      const VoxelCoord voxel = block.coord * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
      const Eigen::Vector3d p_M = (voxel.cast<double>().array() + 0.5) * map.info.voxel_size_m;
      REQUIRE(block.voxels[i] == query.at(p_M).log_odds);
      num_known += block.voxels[i] != kUnknownLogOdds;
    }
  }));
  std::size_t expected = 0;
  for (int z = -60; z < 60; ++z) {
    for (int y = -120; y < 120; ++y) {
      for (int x = -120; x < 120; ++x) {
        const Eigen::Vector3d p_M = (VoxelCoord(x, y, z).cast<double>().array() + 0.5) * 0.1;
        expected += query.at(p_M).state != VoxelState::kUnknown;
      }
    }
  }
  CHECK(num_known == expected);
  CHECK(!for_each_combined_block(map.view(), 64, [](const CombinedBlock&) { CHECK(false); }));
}

TEST_CASE("an aligned submap's blocks are combined block by block") {
  MapBuilder map;
  map.set_coarse(map.add_submap(0, pose_of(-8 * 0.1 * 5, 0, 8 * 0.1 * 9, 0)), {1, 2, 3}, -7);
  int num_blocks = 0;
  REQUIRE(for_each_combined_block(map.view(), 1 << 15, [&](const CombinedBlock& block) {
    ++num_blocks;
    CHECK(block.coord == BlockCoord(-4, 2, 12));
    CHECK(std::all_of(block.voxels.begin(), block.voxels.end(), [](LogOdds v) { return v == -7; }));
  }));
  CHECK(num_blocks == 1);
}

}  // namespace
}  // namespace cloister
