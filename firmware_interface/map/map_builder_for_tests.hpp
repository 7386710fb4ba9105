#pragma once

#include <unistd.h>

#include <cstdint>
#include <deque>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/map/map_contents.hpp"

namespace cloister {

/// A small map put together voxel by voxel, for tests.
struct MapBuilder {
  explicit MapBuilder(std::size_t num_blocks = 4096, std::size_t num_chunks = 256)
      : store(num_blocks, num_chunks), pools(store) {
    pools.take_all();
  }

  Submap& add_submap(SubmapId id, const Pose& T_M_S = Pose::Identity()) {
    Submap& submap = submaps.emplace_back();
    submap.id = id;
    submap.T_M_S = T_M_S;
    submap_ptrs.push_back(&submap);
    return submap;
  }

  void set_voxel(Submap& submap, const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = submap.volume.make_place(pools, parent_coord(voxel), &chunk);
    Block* block = place == nullptr ? nullptr : submap.volume.make_block(pools, *chunk, *place);
    if (block != nullptr) block->voxels[index_in_block(voxel)] = value;
  }

  void set_coarse(Submap& submap, const BlockCoord& coord, LogOdds value,
                  OctantMask known = kAllOctants) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = submap.volume.make_place(pools, coord, &chunk);
    if (place != nullptr) submap.volume.set_coarse(pools, *chunk, *place, value, known);
  }

  /// The same content as `set_coarse` gives, but voxel by voxel.
  void set_plain(Submap& submap, const BlockCoord& coord, LogOdds value, OctantMask known) {
    for (int v = 0; v < kBlockVoxels; ++v) {
      const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(v & 7, v >> 3 & 7, v >> 6);
      if ((known >> octant_of(v) & 1) != 0) set_voxel(submap, voxel, value);
    }
  }

  /// Scatters coarse free space, half of it partly known, and blocks of random voxels (some
  /// unknown) over several chunks around S's origin.
  void fill_randomly(Submap& submap, unsigned seed, int num_blocks = 40) {
    std::mt19937 rng(seed);
    std::uniform_int_distribution<int> coordinate(-9, 8), value(-40, 70);
    for (int i = 0; i < num_blocks; ++i) {
      const BlockCoord coord(coordinate(rng), coordinate(rng), coordinate(rng) / 4);
      if (i % 3 == 0) {
        const auto known = i % 2 == 0 ? kAllOctants : static_cast<OctantMask>(1 + rng() % 254);
        set_coarse(submap, coord, static_cast<LogOdds>(-1 - i % 40), known);
        continue;
      }
      for (int v = 0; v < kBlockVoxels; ++v) {
        const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(v & 7, v >> 3 & 7, v >> 6);
        if (rng() % 4 != 0) set_voxel(submap, voxel, static_cast<LogOdds>(value(rng)));
      }
    }
  }

  [[nodiscard]] MapView view() const { return {info, &store, submap_ptrs}; }

  MapInfo info{0.1, -2.0, 3.5};
  VoxelStore store;
  VoxelPools pools;
  std::deque<Submap> submaps;
  std::vector<const Submap*> submap_ptrs;
};

[[nodiscard]] inline Pose pose_of(double x, double y, double z, double yaw_rad,
                                  double roll_rad = 0) {
  return make_pose({x, y, z},
                   Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX())));
}

/// A directory that lasts as long as the test.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "cloister-map-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cloister
