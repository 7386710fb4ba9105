#include "mapping/fuse/fuser.hpp"

#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

struct TwoVolumes {
  explicit TwoVolumes(std::size_t blocks = 4096) : store(blocks, 256), pools(store) {
    pools.take_all();
  }
  void set(Volume& volume, const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(voxel)] = value;
  }
  void fill(Volume& volume, unsigned seed, int low, int high) {
    std::mt19937 rng(seed);
    std::uniform_int_distribution<int> coordinate(low, high), value(-40, 70);
    for (int i = 0; i < 6000; ++i) {
      set(volume, {coordinate(rng), coordinate(rng), coordinate(rng)},
          static_cast<LogOdds>(value(rng)));
    }
  }
  VoxelStore store;
  VoxelPools pools;
  Volume into, from;
  VoxelConfig config;
};

TEST_CASE("on grids that agree fusion adds log-odds voxel by voxel") {
  TwoVolumes v;
  v.fill(v.into, 1, -20, 20);
  v.fill(v.from, 2, -10, 30);
  TwoVolumes before;
  before.fill(before.into, 1, -20, 20);
  Pose T_from_into = Pose::Identity();
  T_from_into.translation() = Eigen::Vector3d(3, -2, 8) * v.config.voxel_size_m;
  REQUIRE(fuse_volume(v.from, T_from_into, v.config, v.pools, v.into));
  for (int z = -40; z < 40; ++z) {
    for (int y = -40; y < 40; ++y) {
      for (int x = -40; x < 40; ++x) {
        const int a = before.into.at(before.store, {x, y, z});
        const int b = v.from.at(v.store, {x + 3, y - 2, z + 8});
        int expected = std::clamp(a + b, -40, 70);
        if (expected == 0 && b != 0) expected = b < 0 ? -1 : 1;
        if (expected == 0 && b == 0) expected = a;
        REQUIRE(int{v.into.at(v.store, {x, y, z})} == expected);
      }
    }
  }
}

TEST_CASE("fusing with nothing changes nothing") {
  TwoVolumes v;
  v.fill(v.into, 1, -20, 20);
  const std::size_t blocks = v.into.num_blocks();
  REQUIRE(fuse_volume(v.from, Pose::Identity(), v.config, v.pools, v.into));
  CHECK(v.into.num_blocks() == blocks);
}

TEST_CASE("coarse nodes stay coarse") {
  TwoVolumes v;
  for (Volume* volume : {&v.into, &v.from}) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume->make_place(v.pools, {2, 2, 2}, &chunk);
    volume->set_coarse(v.pools, *chunk, *place, -16, kAllOctants);
  }
  REQUIRE(fuse_volume(v.from, Pose::Identity(), v.config, v.pools, v.into));
  CHECK(v.into.num_blocks() == 0);
  CHECK(v.into.at(v.store, {16, 16, 16}) == -32);
}

TEST_CASE("partly known coarse nodes fuse to the same states as the same voxels one by one") {
  for (const Eigen::Vector3d& shift :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(8, 0, -8), Eigen::Vector3d(4, 3, 0)}) {
    TwoVolumes coarse, plain;
    std::mt19937 rng(9);
    const auto add = [&](TwoVolumes& v, Volume& volume, const BlockCoord& coord, LogOdds value,
                         OctantMask known, bool is_coarse) {
      Chunk* chunk = nullptr;
      std::uint32_t* place = volume.make_place(v.pools, coord, &chunk);
      if (is_coarse) return volume.set_coarse(v.pools, *chunk, *place, value, known);
      Block* block = volume.make_block(v.pools, *chunk, *place);
      for (int i = 0; i < kBlockVoxels; ++i)
        block->voxels[i] = known >> octant_of(i) & 1 ? value : kUnknownLogOdds;
    };
    // Free nodes meet free and occupied ones, whole and in parts.
    for (int i = 0; i < 100; ++i) {
      const BlockCoord coord(i % 10, i / 10, 0);
      for (const bool is_into : {true, false}) {
        const auto known = rng() % 3 == 0 ? kAllOctants : static_cast<OctantMask>(rng() % 256);
        const auto value = static_cast<LogOdds>(
            known == kAllOctants && rng() % 3 == 0 ? 25 : -10 - static_cast<int>(rng() % 5));
        if (known == kNoOctants) continue;
        add(coarse, is_into ? coarse.into : coarse.from, coord, value, known, true);
        add(plain, is_into ? plain.into : plain.from, coord, value, known, false);
      }
    }
    Pose T_from_into = Pose::Identity();
    T_from_into.translation() = shift * coarse.config.voxel_size_m;
    REQUIRE(fuse_volume(coarse.from, T_from_into, coarse.config, coarse.pools, coarse.into));
    REQUIRE(fuse_volume(plain.from, T_from_into, plain.config, plain.pools, plain.into));
    int num_known = 0;
    for (int z = -16; z < 24; ++z) {
      for (int y = -16; y < 100; ++y) {
        for (int x = -16; x < 100; ++x) {
          const LogOdds expected = plain.into.at(plain.store, {x, y, z});
          num_known += expected != kUnknownLogOdds;
          REQUIRE(state_of(coarse.into.at(coarse.store, {x, y, z})) == state_of(expected));
        }
      }
    }
    CHECK(num_known > 30'000);
  }
}

TEST_CASE("fusion between rotated grids keeps a plane within a voxel of where it was") {
  TwoVolumes v;
  for (int y = -30; y < 30; ++y) {
    for (int z = -30; z < 30; ++z) v.set(v.from, {10, y, z}, 50);
  }
  Pose T_into_from(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ()));
  REQUIRE(fuse_volume(v.from, T_into_from.inverse(), v.config, v.pools, v.into));
  std::size_t num_occupied = 0;
  v.into.for_each_block(v.store, [&](const BlockCoord& block, const BlockView& view) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (view.at(i) <= 0) continue;
      ++num_occupied;
      const Eigen::Vector3d centre =
          (block.cast<double>() * 8 +
           Eigen::Vector3d((i & 7) + 0.5, ((i >> 3) & 7) + 0.5, (i >> 6) + 0.5));
      CHECK(std::abs((T_into_from.inverse() * centre).x() - 10.5) <= 1.0);
    }
  });
  CHECK(num_occupied > 3300);
}

TEST_CASE("without room in the pools nothing is fused and nothing changes") {
  TwoVolumes v(40);
  for (int i = 0; i < 20; ++i) v.set(v.into, {i * 8, 0, 0}, 5);
  for (int i = 0; i < 15; ++i) v.set(v.from, {i * 8, 80, 0}, 5);
  CHECK_FALSE(fuse_volume(v.from, Pose::Identity(), v.config, v.pools, v.into));
  CHECK(v.into.num_blocks() == 20);
  CHECK(v.into.at(v.store, {0, 80, 0}) == kUnknownLogOdds);
}

}  // namespace
}  // namespace cloister
