#pragma once

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Adds one volume to another: each voxel of `into` that `from` knows takes the sum of both log-odds, clamped. Where
/// the grids agree this is exact; elsewhere each voxel takes the nearest of `from`. `from` is left as it was.
///
/// @param T_from_into  pose of into's frame in from's
/// @return false, with nothing changed, when the pools might not hold the result
/// Threads: one owner of both volumes and the pools. Allocates a list of the blocks concerned.
[[nodiscard]] bool fuse_volume(const Volume& from, const Pose& T_from_into, const VoxelConfig& config,
                               VoxelPools& pools, Volume& into);

}  // namespace cloister
