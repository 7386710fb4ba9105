#include "firmware_interface/map/block_changes.hpp"

#include <algorithm>
#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

/// A volume with memory of its own.
struct OwnVolume {
  VoxelStore store{2048, 128};
  VoxelPools pools{store};
  Volume volume;

  OwnVolume() { pools.take_all(); }
  void set(const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(voxel)] = value;
  }
  void set_coarse(const BlockCoord& coord, LogOdds value, OctantMask known) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, coord, &chunk);
    volume.set_coarse(pools, *chunk, *place, value, known);
  }
  /// What a client does with a delta.
  void apply(const BlockDelta& delta) {
    if (delta.since == 0) volume.clear(pools);
    for (const BlockState& block : delta.blocks) {
      set_coarse(block.coord, block.coarse, block.known);
      if (block.voxels.empty()) continue;
      Chunk* chunk = nullptr;
      std::uint32_t* place = volume.make_place(pools, block.coord, &chunk);
      std::ranges::copy(block.voxels, volume.make_block(pools, *chunk, *place)->voxels);
    }
  }
};

void check_equal(const OwnVolume& a, const OwnVolume& b) {
  int num_different = 0;
  for (int z = -24; z < 24; ++z) {
    for (int y = -24; y < 24; ++y) {
      for (int x = -24; x < 24; ++x) {
        num_different += a.volume.at(a.store, {x, y, z}) != b.volume.at(b.store, {x, y, z});
      }
    }
  }
  CHECK(num_different == 0);
}

TEST_CASE("who applies all deltas holds what the mapper holds, however the volume changes") {
  constexpr unsigned kSeed = 3;
  CAPTURE(kSeed);
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<int> coordinate(-24, 23), block(-3, 2), value(-40, 70),
      known(0, 255);
  OwnVolume mapper, client;
  BlockChanges changes(1000);
  std::uint64_t since = 0;
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < 30; ++i) {
      mapper.set({coordinate(random), coordinate(random), coordinate(random)},
                 static_cast<LogOdds>(value(random)));
      // Also to nothing, as when a place is left to another submap.
      mapper.set_coarse({block(random), block(random), block(random)}, -20,
                        static_cast<OctantMask>(i % 3 == 0 ? 0 : known(random)));
    }
    mapper.volume.release_empty_chunks(mapper.pools);
    changes.update(mapper.store, mapper.volume);
    for (bool is_last = false; !is_last;) {
      const BlockDelta delta = changes.since(mapper.store, mapper.volume, since, 16);
      CHECK(delta.blocks.size() <= 16);
      CHECK(delta.since == since);
      client.apply(delta);
      since = delta.up_to;
      is_last = delta.is_last;
    }
    check_equal(mapper, client);
  }
}

TEST_CASE("only what has changed comes again") {
  OwnVolume mapper;
  for (int x = 0; x < 10; ++x) mapper.set({8 * x, 0, 0}, 20);
  BlockChanges changes(0);
  changes.update(mapper.store, mapper.volume);
  const BlockDelta all = changes.since(mapper.store, mapper.volume, 0, 100);
  CHECK(all.blocks.size() == 10);
  changes.update(mapper.store, mapper.volume);
  CHECK(changes.since(mapper.store, mapper.volume, all.up_to, 100).blocks.empty());
  mapper.set({16, 1, 1}, 20);
  changes.update(mapper.store, mapper.volume);
  const BlockDelta delta = changes.since(mapper.store, mapper.volume, all.up_to, 100);
  REQUIRE(delta.blocks.size() == 1);
  CHECK(delta.blocks[0].coord == BlockCoord(2, 0, 0));
  CHECK(delta.is_last);
}

TEST_CASE("a number of another map begins anew") {
  OwnVolume mapper;
  mapper.set({0, 0, 0}, 20);
  BlockChanges changes(1000);
  changes.update(mapper.store, mapper.volume);
  for (const std::uint64_t stranger : {5ULL, 1000ULL, 2000ULL}) {
    const BlockDelta delta = changes.since(mapper.store, mapper.volume, stranger, 100);
    CHECK(delta.since == 0);
    CHECK(delta.blocks.size() == 1);
  }
}

}  // namespace
}  // namespace cloister
