#include "mapping/voxel/volume.hpp"

#include <doctest/doctest.h>

#include <map>
#include <random>
#include <tuple>

namespace cloister {
namespace {

struct Fixture {
  explicit Fixture(std::size_t blocks = 64, std::size_t chunks = 16) : store(blocks, chunks), pools(store) {
    pools.take_all();
  }
  void set(const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    REQUIRE(place != nullptr);
    Block* block = volume.make_block(pools, *chunk, *place);
    REQUIRE(block != nullptr);
    block->voxels[index_in_block(voxel)] = value;
  }
  VoxelStore store;
  VoxelPools pools;
  Volume volume;
};

TEST_CASE("a fresh volume knows nothing and owns only its table") {
  Fixture f;
  CHECK(f.volume.at(f.store, {0, 0, 0}) == kUnknownLogOdds);
  CHECK(f.volume.bytes() == sizeof(Volume));
  CHECK(f.volume.view(f.store, {-5, 3, 7}).is_unknown());
}

TEST_CASE("voxels on both sides of zero keep their own values") {
  Fixture f;
  f.set({-1, -1, -1}, 5);
  f.set({0, 0, 0}, -7);
  f.set({-64, 63, -65}, 9);
  CHECK(f.volume.at(f.store, {-1, -1, -1}) == 5);
  CHECK(f.volume.at(f.store, {0, 0, 0}) == -7);
  CHECK(f.volume.at(f.store, {-64, 63, -65}) == 9);
  CHECK(f.volume.at(f.store, {1, 0, 0}) == kUnknownLogOdds);
}

TEST_CASE("random writes read back as in a plain map") {
  Fixture f(4096, 512);
  const unsigned seed = 7;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> coordinate(-200, 200), value(-40, 70);
  std::map<std::tuple<int, int, int>, int> expected;
  for (int i = 0; i < 2000; ++i) {
    const VoxelCoord v(coordinate(rng), coordinate(rng) / 4, coordinate(rng) / 16);
    const int log_odds = value(rng);
    f.set(v, static_cast<LogOdds>(log_odds));
    expected[{v.x(), v.y(), v.z()}] = log_odds;
  }
  for (const auto& [key, log_odds] : expected) {
    CHECK(f.volume.at(f.store, {std::get<0>(key), std::get<1>(key), std::get<2>(key)}) == log_odds);
  }
  std::size_t known = 0;
  f.volume.for_each_block(f.store, [&](const BlockCoord&, const BlockView& view) {
    for (int i = 0; i < kBlockVoxels; ++i) known += view.at(i) != kUnknownLogOdds;
  });
  std::size_t expected_known = 0;
  for (const auto& [key, log_odds] : expected) expected_known += log_odds != 0;
  CHECK(known == expected_known);
}

TEST_CASE("a block whose voxels are all free becomes a coarse node with the weakest of them") {
  Fixture f;
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  Block* block = f.volume.make_block(f.pools, *chunk, *place);
  for (int i = 0; i < kBlockVoxels; ++i) block->voxels[i] = static_cast<LogOdds>(-8 - i % 30);
  const std::size_t free_before = f.pools.blocks.num_free();
  CHECK(f.volume.settle_block(f.pools, *chunk, *place));
  CHECK(f.volume.at(f.store, {3, 4, 5}) == -8);
  CHECK(f.pools.blocks.num_free() == free_before + 1);
  CHECK(f.volume.num_blocks() == 0);
}

TEST_CASE("a block of mixed voxels stays a block") {
  Fixture f;
  f.set({0, 0, 0}, -8);
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  CHECK_FALSE(f.volume.settle_block(f.pools, *chunk, *place));
  CHECK(f.volume.num_blocks() == 1);
}

TEST_CASE("a block that rests is read, written, moved and returned as any other") {
  Fixture f;
  f.set({1, 2, 3}, 9);
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  Volume::set_rest(*place, true);
  CHECK(Volume::rests(*place));
  CHECK(f.volume.at(f.store, {1, 2, 3}) == 9);
  f.set({1, 2, 4}, -9);
  CHECK(f.volume.at(f.store, {1, 2, 4}) == -9);
  CHECK(f.volume.num_blocks() == 1);
  const PoolIndex block = f.volume.detach_block(*chunk, *place);
  CHECK_FALSE(Volume::rests(*place));
  f.volume.attach_block(*chunk, *place, block);
  CHECK_FALSE(Volume::rests(*place));
  CHECK(f.volume.at(f.store, {1, 2, 3}) == 9);
  Volume::set_rest(*place, true);
  f.volume.set_coarse(f.pools, *chunk, *place, -3, kAllOctants);
  CHECK_FALSE(Volume::rests(*place));
  CHECK(f.pools.blocks.num_free() == 64);
}

TEST_CASE("a coarse node reads as its value in the octants it knows, and as unknown in the others") {
  Fixture f;
  for (int known = 0; known < 256; ++known) {
    const BlockCoord coord(known % 16 - 8, known / 16 - 8, 0);
    Chunk* chunk = nullptr;
    std::uint32_t* place = f.volume.make_place(f.pools, coord, &chunk);
    f.volume.set_coarse(f.pools, *chunk, *place, -8, static_cast<OctantMask>(known));
    const BlockView view = f.volume.view(f.store, coord);
    CHECK(view.is_unknown() == (known == 0));
    CHECK(view.is_uniform() == (known == 0 || known == 255));
    for (int i = 0; i < kBlockVoxels; ++i) {
      const VoxelCoord local(i & 7, i >> 3 & 7, i >> 6);
      const int octant = local.x() / 4 + 2 * (local.y() / 4) + 4 * (local.z() / 4);
      const LogOdds expected = known >> octant & 1 ? -8 : kUnknownLogOdds;
      REQUIRE(f.volume.at(f.store, coord * kBlockEdge + local) == expected);
    }
  }
  CHECK(f.volume.num_blocks() == 0);
}

TEST_CASE("a coarse node without a value or without octants is unknown") {
  Fixture f;
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  f.volume.set_coarse(f.pools, *chunk, *place, kUnknownLogOdds, kAllOctants);
  CHECK(f.volume.view(f.store, {0, 0, 0}).is_unknown());
  f.volume.set_coarse(f.pools, *chunk, *place, -8, kNoOctants);
  CHECK(f.volume.view(f.store, {0, 0, 0}).is_unknown());
  CHECK(chunk->num_known == 0);
}

TEST_CASE("splitting a coarse node keeps every voxel") {
  for (int known = 1; known < 256; ++known) {
    Fixture f;
    Chunk* chunk = nullptr;
    std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
    f.volume.set_coarse(f.pools, *chunk, *place, -12, static_cast<OctantMask>(known));
    const BlockView before = f.volume.view(f.store, {0, 0, 0});
    const Block* block = f.volume.make_block(f.pools, *chunk, *place);
    REQUIRE(block != nullptr);
    for (int i = 0; i < kBlockVoxels; ++i) REQUIRE(block->voxels[i] == before.at(i));
    CHECK(f.volume.settle_block(f.pools, *chunk, *place));
    const BlockView after = f.volume.view(f.store, {0, 0, 0});
    CHECK(after.coarse == -12);
    CHECK(int{after.known} == known);
  }
}

TEST_CASE("a block that is free or unknown octant by octant settles, with the weakest of its values") {
  Fixture f;
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  f.volume.set_coarse(f.pools, *chunk, *place, -20, 0x5a);
  Block* block = f.volume.make_block(f.pools, *chunk, *place);
  block->voxels[index_in_block(5, 1, 2)] = -3;  // in octant 1, which is known
  CHECK(f.volume.settle_block(f.pools, *chunk, *place));
  const BlockView view = f.volume.view(f.store, {0, 0, 0});
  CHECK(view.coarse == -3);
  CHECK(view.known == 0x5a);
  CHECK(f.pools.blocks.num_free() == f.store.num_blocks());
}

TEST_CASE("a block with one unknown voxel in a free octant, or one occupied voxel, does not settle") {
  for (const LogOdds odd_one : {kUnknownLogOdds, LogOdds{4}}) {
    Fixture f;
    Chunk* chunk = nullptr;
    std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
    f.volume.set_coarse(f.pools, *chunk, *place, -20, 0x5a);
    Block* block = f.volume.make_block(f.pools, *chunk, *place);
    block->voxels[index_in_block(5, 1, 2)] = odd_one;
    CHECK_FALSE(f.volume.settle_block(f.pools, *chunk, *place));
    CHECK(f.volume.num_blocks() == 1);
  }
}

TEST_CASE("a block that is occupied throughout becomes one coarse node") {
  Fixture f;
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  Block* block = f.volume.make_block(f.pools, *chunk, *place);
  for (int i = 0; i < kBlockVoxels; ++i) block->voxels[i] = static_cast<LogOdds>(17 + i % 50);
  CHECK(f.volume.settle_block(f.pools, *chunk, *place));
  CHECK(f.volume.view(f.store, {0, 0, 0}).coarse == 17);
  CHECK(f.volume.view(f.store, {0, 0, 0}).known == kAllOctants);
}

TEST_CASE("a block becomes a coarse node at once when it is set to one value") {
  Fixture f;
  f.set({0, 0, 0}, 5);
  Chunk* chunk = nullptr;
  std::uint32_t* place = f.volume.make_place(f.pools, {0, 0, 0}, &chunk);
  f.volume.set_coarse(f.pools, *chunk, *place, -8, 0x0f);
  CHECK(f.volume.num_blocks() == 0);
  CHECK(f.pools.blocks.num_free() == f.store.num_blocks());
  CHECK(f.volume.at(f.store, {7, 7, 3}) == -8);
  CHECK(f.volume.at(f.store, {0, 0, 4}) == kUnknownLogOdds);
}

TEST_CASE("an empty pool declines and leaves the volume as it was") {
  Fixture f(1, 1);
  f.set({0, 0, 0}, 3);
  Chunk* chunk = nullptr;
  CHECK(f.volume.make_place(f.pools, {100, 0, 0}, &chunk) == nullptr);
  std::uint32_t* place = f.volume.make_place(f.pools, {1, 0, 0}, &chunk);
  REQUIRE(place != nullptr);
  CHECK(f.volume.make_block(f.pools, *chunk, *place) == nullptr);
  CHECK(f.volume.at(f.store, {0, 0, 0}) == 3);
  CHECK(f.volume.num_blocks() == 1);
}

TEST_CASE("clearing returns every item to the pools") {
  Fixture f;
  for (int i = 0; i < 10; ++i) f.set({i * 40, -i * 7, i}, 1);
  f.volume.clear(f.pools);
  CHECK(f.pools.blocks.num_free() == f.store.num_blocks());
  CHECK(f.pools.chunks.num_free() == f.store.num_chunks());
  CHECK(f.volume.bytes() == sizeof(Volume));
  CHECK(f.volume.at(f.store, {0, 0, 0}) == kUnknownLogOdds);
}

TEST_CASE("a moved volume takes its content along") {
  Fixture f;
  f.set({1, 2, 3}, 4);
  Volume other = std::move(f.volume);
  CHECK(other.at(f.store, {1, 2, 3}) == 4);
  CHECK(f.volume.num_chunks() == 0);
}

}  // namespace
}  // namespace cloister
