#pragma once

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// What becomes of a voxel that both volumes know.
enum class BothKnown {
  kAdd,   ///< the sum of both log-odds, clamped: both measured equally well
  kKeep,  ///< what `into` says stands: it measured better, and the other would only blur it
};

/// Adds one volume to another: each voxel of `into` takes what `from` knows of it. Where the grids agree this is exact;
/// elsewhere each voxel takes what the nearest eight of `from` say together, or the nearest one if it knew nothing.
/// `from` is left as it was.
///
/// @param T_from_into  pose of into's frame in from's
/// @return false, with nothing changed, when the pools might not hold the result
/// Threads: one owner of both volumes and the pools. Allocates a list of the blocks concerned.
[[nodiscard]] bool fuse_volume(const Volume& from, const Pose& T_from_into,
                               const VoxelConfig& config, VoxelPools& pools, Volume& into,
                               BothKnown rule = BothKnown::kAdd);

}  // namespace cloister
