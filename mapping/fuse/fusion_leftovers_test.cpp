#include "mapping/fuse/fusion_leftovers.hpp"

#include <doctest/doctest.h>

#include "mapping/mesh/marching_cubes.hpp"

namespace cloister {
namespace {

struct OneVolume {
  OneVolume() { pools.take_all(); }
  VoxelStore store{512, 64};
  VoxelPools pools{store};
  Volume volume;

  void set(const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(voxel)] = value;
  }
  void fill(const VoxelCoord& low, const VoxelCoord& high, LogOdds value) {
    for (int z = low.z(); z < high.z(); ++z) {
      for (int y = low.y(); y < high.y(); ++y) {
        for (int x = low.x(); x < high.x(); ++x) set({x, y, z}, value);
      }
    }
  }
  [[nodiscard]] LogOdds at(int x, int y, int z) const { return volume.at(store, {x, y, z}); }
};

TEST_CASE("of a thick wall the two layers next to free space stay, whichever way it looks") {
  for (const int axis : {0, 1, 2}) {
    for (const bool is_reversed : {false, true}) {
      CAPTURE(axis);
      CAPTURE(is_reversed);
      OneVolume v;
      // Free up to 13, then a wall as far as 29: across the border of blocks at 16.
      const auto place = [&](int depth, int i, int j) {
        VoxelCoord at;
        at[axis] = is_reversed ? -1 - depth : depth;
        at[(axis + 1) % 3] = i;
        at[(axis + 2) % 3] = j;
        return at;
      };
      for (int i = 0; i < 24; ++i) {
        for (int j = 0; j < 24; ++j) {
          for (int depth = 8; depth < 30; ++depth) v.set(place(depth, i, j), depth < 14 ? -20 : 30);
        }
      }
      CHECK(forget_wall_interiors(v.pools, v.volume) == 2 * 9);
      const auto at = [&](int depth) { return v.volume.at(v.store, place(depth, 12, 12)); };
      CHECK(at(13) == -20);
      CHECK(at(14) == 30);
      CHECK(at(15) == 30);
      for (int depth = 16; depth < 30; ++depth) CHECK(at(depth) == kUnknownLogOdds);
      CHECK(v.volume.num_blocks() == 9);
      CHECK(forget_wall_interiors(v.pools, v.volume) == 0);
    }
  }
}

TEST_CASE("free space that a coarse node holds has a wall's front beside it as well") {
  OneVolume v;
  v.fill({8, 0, 0}, {13, 8, 8}, 30);
  Chunk* chunk = nullptr;
  std::uint32_t* place = v.volume.make_place(v.pools, {0, 0, 0}, &chunk);
  // Of the octants at the wall only the lower ones.
  v.volume.set_coarse(v.pools, *chunk, *place, -20, 0b00001111);
  CHECK(forget_wall_interiors(v.pools, v.volume) == 0);
  CHECK(v.at(8, 3, 1) == 30);
  CHECK(v.at(9, 3, 1) == 30);
  CHECK(v.at(10, 3, 1) == kUnknownLogOdds);
  CHECK(v.at(12, 3, 1) == kUnknownLogOdds);
  // The upper ones are as deep as it takes to get there.
  CHECK(v.at(8, 3, 4) == 30);
  CHECK(v.at(8, 3, 5) == kUnknownLogOdds);
}

TEST_CASE("no surface is lost, whichever way it is inclined") {
  for (const Eigen::Vector3i& slope :
       {Eigen::Vector3i(1, 1, 1), {-1, 1, 1}, {1, -1, -1}, {2, 1, 0}, {1, 3, -2}, {0, -1, 1}}) {
    CAPTURE(slope.transpose());
    OneVolume v;
    for (int z = -12; z < 12; ++z) {
      for (int y = -12; y < 12; ++y) {
        for (int x = -12; x < 12; ++x) {
          const int depth = slope.dot(VoxelCoord(x, y, z));
          v.set({x, y, z}, depth < 0 ? -20 : 30);
        }
      }
    }
    const TriangleMesh before = extract_mesh(v.store, v.volume, 0.1);
    const TriangleMesh deep_before = extract_mesh(v.store, v.volume, 0.1, 1);
    (void)forget_wall_interiors(v.pools, v.volume);
    CHECK(v.at(10 * slope.x() / 3, 10 * slope.y() / 3, 10 * slope.z() / 3) == kUnknownLogOdds);
    const TriangleMesh after = extract_mesh(v.store, v.volume, 0.1);
    REQUIRE(before.triangles.size() > 500);
    CHECK(after.triangles.size() == before.triangles.size());
    CHECK(after.vertices_S == before.vertices_S);
    // Where the second layer was in a block of its own the surface is drawn half a voxel less deep.
    const TriangleMesh deep_after = extract_mesh(v.store, v.volume, 0.1, 1);
    REQUIRE(deep_after.vertices_S.size() == deep_before.vertices_S.size());
    std::size_t num_same = 0;
    for (std::size_t i = 0; i < deep_after.vertices_S.size(); ++i) {
      const float moved_m = (deep_after.vertices_S[i] - deep_before.vertices_S[i]).norm();
      num_same += moved_m == 0;
      CHECK(moved_m < 0.0501f);
    }
    CHECK(10 * num_same > 9 * deep_after.vertices_S.size());
  }
}

TEST_CASE("walls seen from both sides stay as they are") {
  OneVolume v;
  v.fill({0, 0, 0}, {8, 8, 2}, -20);
  v.fill({0, 0, 2}, {8, 8, 6}, 30);
  v.fill({0, 0, 6}, {8, 8, 8}, -20);
  CHECK(forget_wall_interiors(v.pools, v.volume) == 0);
  for (int z = 2; z < 6; ++z) CHECK(v.at(4, 4, z) == 30);
}

TEST_CASE("of a block in which nothing touches free space nothing stays, by a corner is enough") {
  OneVolume v;
  v.fill({0, 0, 0}, {8, 8, 7}, -20);
  v.fill({0, 0, 7}, {8, 8, 9}, 30);  // the second layer is in the next block
  v.set({8, 8, 7}, 30);              // beside no free voxel, at the corner of one
  v.set({40, 40, 40}, 30);           // with nothing known around it
  REQUIRE(v.volume.num_blocks() == 4);
  CHECK(forget_wall_interiors(v.pools, v.volume) == 2);
  CHECK(v.at(4, 4, 7) == 30);
  CHECK(v.at(8, 8, 7) == 30);
  CHECK(v.at(4, 4, 8) == kUnknownLogOdds);
  CHECK(v.at(40, 40, 40) == kUnknownLogOdds);
}

TEST_CASE(
    "a block without anything occupied becomes coarse, free where three quarters of an octant "
    "are") {
  OneVolume v;
  v.fill({0, 0, 0}, {4, 4, 3}, -20);  // 48 of an octant's voxels
  v.fill({4, 0, 0}, {8, 4, 2}, -30);  // 32
  v.set({0, 0, 0}, -5);
  v.set({8, 0, 0}, -20);    // alone in its block
  v.set({200, 0, 0}, -20);  // and in its chunk
  v.fill({0, 8, 0}, {4, 12, 3}, -20);
  v.set({0, 8, 3}, 30);
  REQUIRE(v.volume.num_blocks() == 4);
  REQUIRE(v.volume.num_chunks() == 2);
  CHECK(settle_free_space(v.pools, v.volume) == 3);
  CHECK(v.volume.num_blocks() == 1);
  CHECK(v.volume.num_chunks() == 1);
  // The weakest value stands for all of it, and the corner that was not seen is as free as the rest.
  CHECK(v.at(1, 1, 1) == -5);
  CHECK(v.at(1, 1, 3) == -5);
  CHECK(v.at(5, 1, 1) == kUnknownLogOdds);
  CHECK(v.at(8, 0, 0) == kUnknownLogOdds);
  // Where something is occupied nothing has changed.
  CHECK(v.at(0, 8, 3) == 30);
  CHECK(v.at(1, 8, 3) == kUnknownLogOdds);
  CHECK(v.at(1, 8, 2) == -20);
}

}  // namespace
}  // namespace cloister
