#pragma once

#include <array>
#include <functional>

#include "firmware_interface/map/map_contents.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// 8x8x8 voxels of a grid that is parallel to M's axes,
/// with what all submaps together know at each voxel's centre.
struct CombinedBlock {
  BlockCoord coord;                          ///< in M's grid: covers [8 coord, 8 coord + 8) voxels
  std::array<LogOdds, kBlockVoxels> voxels;  ///< x fastest, then y, then z
};

/// Resamples the map into one grid: every voxel says what a query at its centre would say. Visits
/// the blocks in which anything is known, in the order z, y, x.
/// @param max_voxel_coord  bound of the grid's voxel coordinates
/// @return false, before anything is visited, when the map reaches beyond the bound
///
/// Allocates 16 bytes for each pair of a submap and a block of the grid that it may know.
[[nodiscard]] bool for_each_combined_block(const MapView& map, int max_voxel_coord,
                                           const std::function<void(const CombinedBlock&)>& visit);

}  // namespace cloister
