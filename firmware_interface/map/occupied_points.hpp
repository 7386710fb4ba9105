#pragma once

#include <cstdint>

#include "firmware_interface/map/map_contents.hpp"

namespace cloister {

/// Calls `visit(const Submap&, const Eigen::Vector3d& p_M)` with the centre of every occupied
/// voxel, submap by submap in ascending id. Where submaps overlap each has its own points.
template <typename Visitor>
void for_each_occupied_point(const MapView& map, Visitor&& visit) {
  for (const Submap* submap : sorted_submaps(map)) {
    submap->volume.for_each_block(*map.store, [&](const BlockCoord& coord, const BlockView& view) {
      if (view.block == nullptr && view.coarse < 0) return;
      for (int i = 0; i < kBlockVoxels; ++i) {
        if (view.at(i) <= 0) continue;
        const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
        const Eigen::Vector3d p_S = (voxel.cast<double>().array() + 0.5) * map.info.voxel_size_m;
        visit(*submap, Eigen::Vector3d(submap->T_M_S * p_S));
      }
    });
  }
}

[[nodiscard]] inline std::uint64_t count_occupied(const MapView& map) {
  std::uint64_t count = 0;
  for (const Submap* submap : map.submaps) {
    submap->volume.for_each_block(*map.store, [&](const BlockCoord&, const BlockView& view) {
      for (int i = 0; i < kBlockVoxels; ++i) count += view.at(i) > 0;
    });
  }
  return count;
}

}  // namespace cloister
