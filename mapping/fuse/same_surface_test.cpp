#include "mapping/fuse/same_surface.hpp"

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr double kVoxelM = 0.065;

/// An empty room of 6 x 6 x 5 blocks, free inside, its walls one voxel thick.
struct Room {
  Room(VoxelPools& pools) {
    const VoxelCoord high(47, 47, 39);
    for (int z = 0; z <= high.z(); ++z) {
      for (int y = 0; y <= high.y(); ++y) {
        for (int x = 0; x <= high.x(); ++x) {
          const VoxelCoord v(x, y, z);
          const bool is_wall = (v.array() == 0).any() || (v.array() == high.array()).any();
          Chunk* chunk = nullptr;
          std::uint32_t* place = volume.make_place(pools, parent_coord(v), &chunk);
          volume.make_block(pools, *chunk, *place)->voxels[index_in_block(v)] = is_wall ? 30 : -30;
        }
      }
    }
  }
  Volume volume;
};

double share_when_moved(const Eigen::Vector3d& moved_m) {
  VoxelStore store(1000, 16);
  VoxelPools pools(store);
  pools.take_all();
  const Room a(pools), b(pools);
  Pose T_b_a = Pose::Identity();
  T_b_a.translation() = moved_m;
  return compare_surfaces(store, a.volume, b.volume, T_b_a, kVoxelM).share_same();
}

TEST_CASE("two views of one room show the same surfaces, within what a fusion bears") {
  CHECK(share_when_moved({0, 0, 0}) == 1);
  CHECK(share_when_moved({0.1, -0.1, 0.05}) > 0.95);
}

TEST_CASE("walls three voxels apart are two walls") {
  CHECK(share_when_moved({0.2, 0.2, 0}) < 0.8);
}

TEST_CASE("a metre aside floors and ceilings agree, and walls do not") {
  const double share = share_when_moved({0.7, 0.7, 0});
  CHECK(share > 0.3);
  CHECK(share < 0.82);
}

TEST_CASE("rows of returns with nothing known between them do not contradict those of another view") {
  VoxelStore store(1000, 16);
  VoxelPools pools(store);
  pools.take_all();
  Volume near_rows, far_rows, free_below;
  const auto set = [&](Volume& volume, const VoxelCoord& v, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(v), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(v)] = value;
  };
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (x % 8 == 0) set(near_rows, {x, y, 3}, 30);
      if (x % 8 == 4) set(far_rows, {x, y, 3}, 30);
      set(free_below, {x, y, 3}, -30);
    }
  }
  const auto share = [&](const Volume& a, const Volume& b) {
    return compare_surfaces(store, a, b, Pose::Identity(), kVoxelM).share_same();
  };
  CHECK(share(near_rows, far_rows) == 1);
  CHECK(share(near_rows, near_rows) == 1);
  CHECK(share(near_rows, free_below) == 0);
}

TEST_CASE("volumes that know nothing in common show nothing apart") {
  CHECK(share_when_moved({100, 0, 0}) == 1);
}

}  // namespace
}  // namespace cloister
