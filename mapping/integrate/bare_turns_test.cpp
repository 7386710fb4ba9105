#include "mapping/integrate/bare_turns.hpp"

#include <doctest/doctest.h>

#include "mapping/integrate/projective.hpp"
#include "mapping/integrate/scene_for_tests.hpp"

namespace cloister {
namespace {

TEST_CASE("bare blocks take more turns where there are many") {
  BareTurns bare;
  CHECK(bare.turns() == BareTurns::kMinTurns);
  bare.choose(2'000, 7'000);
  CHECK(bare.turns() == BareTurns::kMinTurns);
  bare.choose(2'000, 50'000);
  CHECK(bare.turns() == BareTurns::kMaxTurns);
  bare.choose(40'000, 1'000'000);
  CHECK(bare.turns() == BareTurns::kMaxTurns);
}

TEST_CASE("turns that suffice stay until there is room to spare") {
  BareTurns bare;
  bare.choose(0, 50'000);
  REQUIRE(bare.turns() == 3);
  bare.choose(0, 25'000);
  CHECK(bare.turns() == 3);
  // 54,000 in all would be few enough for two turns, but not by much.
  bare.choose(0, 18'000);
  CHECK(bare.turns() == 3);
  bare.choose(0, 13'500);
  CHECK(bare.turns() == 2);
}

TEST_CASE("taking turns, bare blocks are known as well, only later") {
  const ScanGeometry geometry = geometry_of(long_range_sensor(512));
  Scene scene;
  scene.add_room({-30, -22, -2}, {28, 25, 9});
  // A row of pillars casts shadows, along which blocks are seen in part.
  for (int i = 0; i < 8; ++i) {
    const float y = -9 + 2.5f * static_cast<float>(i);
    scene.boxes.push_back({{9, y, -2}, {9.4f, y + 0.4f, 4}});
  }
  const Scan scan = see(scene, geometry, standing(upright_pose(0.2, 0.1, 0)));
  const VoxelConfig config;
  const Evidence evidence(config);
  const auto known_after = [&](int num_scans, int turns) {
    SceneMap map(geometry);
    REQUIRE(map.beams.assign(scan, Pose::Identity(), config) == 0);
    ScanMarks marks(config.voxel_size_m, config.max_range_m, 5, 1 << 16);
    // Not from 0: the first scan of all asks everything.
    for (int i = 0; i < num_scans; ++i) {
      marks.restart({0, 0, 0});
      marks.mark_returns(map.beams);
      const ProjectiveResult result = integrate_projective(
          {map.beams.image(), evidence, config.voxel_size_m, config.max_range_m,
           static_cast<std::uint64_t>(i + 1), turns, marks, map.pools, map.volume});
      CHECK(result.voxels_declined == 0);
    }
    std::size_t count = 0;
    map.volume.for_each_block(map.store, [&](const BlockCoord&, const BlockView& view) {
      for (int i = 0; i < kBlockVoxels; ++i) count += view.at(i) != kUnknownLogOdds;
    });
    return static_cast<double>(count);
  };
  const double all = known_after(3 * BareTurns::kMaxTurns, 1);
  CHECK(known_after(3, BareTurns::kMaxTurns) < 0.999 * all);
  CHECK(known_after(3 * BareTurns::kMaxTurns, BareTurns::kMaxTurns) > 0.999 * all);
}

}  // namespace
}  // namespace cloister
