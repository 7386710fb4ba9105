#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// A wall: all points p of the world with normal . p = offset.
struct Wall {
  Eigen::Vector3d normal;
  double offset_m;
};

inline Eigen::Vector3d level(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

/// A room of 5 x 4 x 2.5 m, none of whose sides is along a grid.
inline std::vector<Wall> tilted_room() {
  const Eigen::Vector3d up = Eigen::Vector3d(0.05, 0.03, 1).normalized();
  return {{level(20), 2.5},  {-level(20), 2.5}, {level(108), 2.0},
          {-level(108), 2.0}, {up, 1.25},        {-up, 1.25}};
}

/// Two walls and a floor that go on for ever: nothing tells where along them one is.
inline std::vector<Wall> corridor() {
  return {{level(90), 1.0}, {-level(90), 1.0}, {-Eigen::Vector3d::UnitZ(), 1.0}};
}

/// What the inside of some walls is in a submap that lies at T_W_S: free between walls one voxel thick, and `behind_m`.
inline Volume view_of_walls(const std::vector<Wall>& walls, const Pose& T_W_S, VoxelPools& pools,
                            double voxel_m, double half_length_m = 3, double behind_m = 0) {
  Volume volume;
  const int reach = static_cast<int>(half_length_m / voxel_m);
  for (int z = -reach / 2; z < reach / 2; ++z) {
    for (int y = -reach; y < reach; ++y) {
      for (int x = -reach; x < reach; ++x) {
        const VoxelCoord v(x, y, z);
        const Eigen::Vector3d p_W =
            T_W_S * Eigen::Vector3d((v.cast<double>().array() + 0.5).matrix() * voxel_m);
        double inside_m = 1e9;
        for (const Wall& wall : walls)
          inside_m = std::min(inside_m, wall.offset_m - wall.normal.dot(p_W));
        if (inside_m < -0.5 * voxel_m - behind_m) continue;
        Chunk* chunk = nullptr;
        std::uint32_t* place = volume.make_place(pools, parent_coord(v), &chunk);
        volume.make_block(pools, *chunk, *place)->voxels[index_in_block(v)] =
            inside_m < 0.5 * voxel_m ? 30 : -30;
      }
    }
  }
  return volume;
}

/// A row of 4 x 4 blocks, each half occupied so that walls run along x.
inline void add_half_walls(int x_blocks, VoxelPools& pools, Volume& volume) {
  for (int y = 0; y < 4; ++y) {
    for (int z = 0; z < 4; ++z) {
      Chunk* chunk = nullptr;
      std::uint32_t* place = volume.make_place(pools, {x_blocks, y, z}, &chunk);
      Block* block = volume.make_block(pools, *chunk, *place);
      for (int i = 0; i < kBlockVoxels; ++i) block->voxels[i] = (i >> 3 & 7) < 4 ? LogOdds{30} : LogOdds{-30};
    }
  }
}

}  // namespace cloister
