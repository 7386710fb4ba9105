#pragma once

#include <cstddef>

#include "mapping/integrate/evidence.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Applies a scan's marks of one block to a volume: `crossed` voxels become more free, `hit` ones more occupied; a voxel
/// that is both is hit (see apply_to_place for what becomes of coarse nodes).
/// @return number of voxels that a full pool declined
/// Real-time: no allocation.
[[nodiscard]] std::size_t apply_marks(const Evidence& evidence, const ScanMarks::Marked& marked,
                                      VoxelPools& pools, Volume& volume);

}  // namespace cloister
