#pragma once

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Two submaps of one place can agree on most of its free space and still see its walls in different places: then one of
/// them does not lie where the graph says, however sure the graph is. Surfaces tell this apart from the error that a
/// fusion is meant to bear: one that is met within three voxels, 0.2 m, is the same.

/// True when a volume knows half as much of a place as another one's block does: a glimpse through its edge is no copy.
/// @param middle_into  of the block, metres in the volume's frame
[[nodiscard]] bool knows_block(const VoxelStore& store, const BlockView& view, const Volume& into,
                               const Eigen::Vector3f& middle_into, float block_m);

/// What two volumes say about the place of one block.
struct BlockAgreement {
  bool is_same_surface = false;  ///< each shows the other's surface within three voxels
  bool is_aligned = false;       ///< each shows the other's surface within one voxel
  double share_known = 0;  ///< of what the block's volume knows, how much `into` knows as well
};

/// Compares a block with what another volume knows there, from a fifth of its voxels. Surfaces are asked for both ways: a
/// block that is free where `into` has a wall contradicts it.
/// @param coord, view   the block, of `from`
/// @param T_into_from   pose of from's frame in into's
[[nodiscard]] BlockAgreement compare_block(const VoxelStore& store, const BlockCoord& coord,
                                           const BlockView& view, const Volume& from,
                                           const Volume& into, const Eigen::Isometry3f& T_into_from,
                                           float voxel_m);

/// True when `into` has something occupied within reach of most of what a block holds occupied, or when that is nothing.
/// @param coord, view   the block, of another volume
/// @param T_into_from   pose of that volume's frame in into's
[[nodiscard]] bool shows_same_surface(const VoxelStore& store, const BlockCoord& coord,
                                      const BlockView& view, const Volume& into,
                                      const Eigen::Isometry3f& T_into_from, float voxel_m);

/// Share of a's blocks with surfaces, among those that b knows about, whose surface b shows as well; 1 when there are
/// none. No allocation; O(occupied voxels of a). @param T_b_a  pose of a's frame in b's
[[nodiscard]] double same_surface_share(const VoxelStore& store, const Volume& a, const Volume& b,
                                        const Pose& T_b_a, double voxel_size_m);

}  // namespace cloister
