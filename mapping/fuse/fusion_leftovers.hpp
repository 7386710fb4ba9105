#pragma once

#include <cstddef>

#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Forgets what lies inside walls. No beam sees behind a surface, so whatever noise and the errors of poses have put
/// there is never cleared, and every fusion adds to it: walls would grow thick to the back without end, and hold more
/// memory than all that is seen of them.
///
/// Occupied voxels that touch free space by as much as a corner stay, and those that touch the ones with a face in common
/// with it: the mesh is the same without the rest (see extract_mesh), which becomes unknown. Of a block in which nothing
/// touches free space nothing stays: it would hold the second layer of its neighbour's wall, in a grid that cuts the wall
/// there, or a few returns with nothing known around them. Where such a block goes the mesh cannot tell how thick a wall is.
///
/// @return number of blocks that went back to the pool
/// Threads: one owner of the volume and the pools. Allocates a list of the blocks with occupied voxels.
std::size_t forget_wall_interiors(VoxelPools& pools, Volume& volume);

/// Makes free space coarse again. A fusion lays the free octants of one grid on another that is turned against it, and
/// leaves blocks of voxels wherever their borders cut one. A block in which nothing is occupied becomes a coarse node: an
/// octant is free when three quarters of its voxels are, as when a scan sees through it (see integrate_projective), and
/// unknown otherwise.
///
/// @return number of blocks that went back to the pool
/// Threads: one owner of the volume and the pools. Allocates a list of the blocks concerned.
std::size_t settle_free_space(VoxelPools& pools, Volume& volume);

/// Octants of a block that settle_free_space takes for free, if nothing is occupied in the block.
[[nodiscard]] OctantMask octants_seen_free(const BlockView& view);

/// Makes the occupied voxels of a block unknown, but for those that are needed. The block must be there.
void forget_occupied(VoxelPools& pools, Volume& volume, const BlockCoord& coord, const BlockBits& needed);

}  // namespace cloister
