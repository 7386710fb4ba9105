#include <set>
#include <tuple>

#include <doctest/doctest.h>

#include "bench/integration/map_quality.hpp"
#include "bench/integration/truth_points.hpp"

namespace cloister {
namespace {

/// A map of voxels with an edge of 0.1 m, known from x = 0 to 3 m: free, but for what is named.
class RowMap {
 public:
  std::set<int> occupied;
  std::set<int> unknown;

  StateAt state_at() const {
    return [this](const Eigen::Vector3f& p_S) {
      const int x = static_cast<int>(std::floor(p_S.x() / kVoxelM));
      if (occupied.contains(x)) return VoxelState::kOccupied;
      if (unknown.contains(x) || x < 0 || x >= 30) return VoxelState::kUnknown;
      return VoxelState::kFree;
    };
  }
  static constexpr float kVoxelM = 0.1f;
};

Beam beam_to(float x_m) { return {{0.05f, 0, 0}, {x_m, 0, 0}, false}; }

BeamQuality judge(const RowMap& map, const Beam& beam) {
  BeamQuality quality;
  judge_beam(beam, RowMap::kVoxelM, map.state_at(), quality);
  return quality;
}

TEST_CASE("points before the end of a beam keep more than three voxels away from it") {
  RowMap map;
  map.occupied = {20};
  // 1.99 m long: of the 18 points those from 85 % on are less than three voxels from the end.
  const BeamQuality quality = judge(map, beam_to(2.04f));
  CHECK(quality.before_end.total() == 15);
  CHECK(quality.before_end.share(VoxelState::kFree) == 1);
}

TEST_CASE("points before the end of a beam are counted by what the map says") {
  RowMap map;
  map.occupied = {4};
  map.unknown = {10};
  const BeamQuality quality = judge(map, beam_to(2.04f));
  // Points are nearly a voxel apart: each voxel is met once.
  CHECK(quality.before_end.counts[0] == 1);
  CHECK(quality.before_end.counts[1] == 13);
  CHECK(quality.before_end.counts[2] == 1);
}

TEST_CASE("an end is occupied when the map is so within one voxel along the beam") {
  for (const int offset : {-1, 0, 1}) {
    CAPTURE(offset);
    RowMap map;
    map.occupied = {20 + offset};
    CHECK(judge(map, beam_to(2.04f)).ends.share(VoxelState::kOccupied) == 1);
  }
  for (const int offset : {-2, 2}) {
    CAPTURE(offset);
    RowMap map;
    map.occupied = {20 + offset};
    CHECK(judge(map, beam_to(2.04f)).ends.share(VoxelState::kFree) == 1);
  }
}

TEST_CASE("an end is unknown only when the map knows none of the three points") {
  RowMap map;
  map.unknown = {19, 20, 21};
  CHECK(judge(map, beam_to(2.04f)).ends.share(VoxelState::kUnknown) == 1);
  map.unknown = {20, 21};
  CHECK(judge(map, beam_to(2.04f)).ends.share(VoxelState::kFree) == 1);
}

TEST_CASE("an end is counted in the bin of its range, and as ground when it is") {
  const StateAt nothing = [](const Eigen::Vector3f&) { return VoxelState::kUnknown; };
  BeamQuality quality;
  for (const float range_m : {0.3f, 1.0f, 4.9f, 5.1f, 20.0f, 59.0f, 70.0f}) {
    judge_beam({{0, 0, 0}, {0, range_m, 0}, range_m < 2}, 0.1f, nothing, quality);
  }
  CHECK(quality.ends.total() == 7);
  CHECK(quality.ends_by_range[0].total() == 2);
  CHECK(quality.ends_by_range[1].total() == 1);
  CHECK(quality.ends_by_range[2].total() == 1);
  CHECK(quality.ends_by_range[3].total() == 1);
  CHECK(quality.ground_ends.total() == 2);
}

TEST_CASE("shares against the truth are of known free space and of all points in solids") {
  RowMap map;
  map.occupied = {1, 20};
  map.unknown = {2, 21};
  const Eigen::Vector3d origin_A(100, 0, 0);
  std::vector<TruthPoint> points;
  for (int x = 0; x < 5; ++x)
    points.push_back({origin_A + Eigen::Vector3d(0.1 * x + 0.05, 0, 0), false});
  for (int x = 20; x < 24; ++x)
    points.push_back({origin_A + Eigen::Vector3d(0.1 * x + 0.05, 0, 0), true});
  const TruthQuality quality = judge_points(points, origin_A, map.state_at());
  CHECK(quality.false_occupied() == doctest::Approx(0.25));  // one of four known points
  CHECK(quality.false_free() == doctest::Approx(0.5));       // two of four points
}

TEST_CASE("shares of nothing are zero") {
  CHECK(StateCounts{}.share(VoxelState::kFree) == 0);
  CHECK(TruthQuality{}.false_occupied() == 0);
  CHECK(TruthQuality{}.false_free() == 0);
}

TEST_CASE("truth points are read as they are written, and a malformed line is refused") {
  const auto points = parse_truth_points("x,y,z,solid\n1,2.5,-3e-1,0\n0,0,0,1\n");
  REQUIRE(points.has_value());
  REQUIRE(points->size() == 2);
  CHECK((*points)[0].p_A == Eigen::Vector3d(1, 2.5, -0.3));
  CHECK_FALSE((*points)[0].is_solid);
  CHECK((*points)[1].is_solid);
  for (const char* row : {"1,2,3", "1,2,3,4", "1,2,3,0,", "1,,3,0", "a,2,3,1"}) {
    CAPTURE(row);
    const auto refused = parse_truth_points(std::string("x,y,z,solid\n") + row + "\n");
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().message.find("line 2") != std::string::npos);
  }
}

}  // namespace
}  // namespace cloister
