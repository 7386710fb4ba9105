#pragma once

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Two submaps of one place can agree on most of its free space and still see its walls in different places: then one of
/// them does not lie where the graph says, however sure the graph is. Surfaces tell this apart from the error that a
/// fusion is meant to bear: one that is met within three voxels, 0.2 m, is the same.

/// How many voxels a volume knows in the place of another one's block, for each that the block knows.
/// @param middle_into  of the block, metres in the volume's frame
[[nodiscard]] double known_ratio(const VoxelStore& store, const BlockView& view, const Volume& into,
                                 const Eigen::Vector3f& middle_into, float block_m);
/// The least ratio at which a volume says something about a block's place: below, it glimpses it.
inline constexpr double kMinKnownRatio = 0.5;

/// What two volumes say about the place of one block.
struct BlockAgreement {
  double share_same = 1;    ///< of the block's surface, how much `into` shows within three voxels
  bool is_aligned = false;  ///< each shows the other's surface within one voxel
  double share_known = 0;   ///< of what the block's volume knows, how much `into` knows as well
};

/// Compares a block with what another volume knows there, from a fifth of its voxels. Surfaces are asked for both ways: a
/// block that is free where `into` has a wall contradicts it.
/// @param coord, view   the block, of `from`
/// @param T_into_from   pose of from's frame in into's
[[nodiscard]] BlockAgreement compare_block(const VoxelStore& store, const BlockCoord& coord,
                                           const BlockView& view, const Volume& from,
                                           const Volume& into, const Eigen::Isometry3f& T_into_from,
                                           float voxel_m);

/// How much of a block's surface `into` shows: of its occupied voxels with a face in common with free space, the share
/// where `into` goes from free to occupied in the same direction, within two voxels, so that a wall's other side does not
/// count. Of a block without any, the share of its occupied voxels that have one of `into` within two voxels.
[[nodiscard]] double share_shown(const VoxelStore& store, const BlockCoord& coord, const BlockView& view,
                                 const Volume& from, const Volume& into, const Eigen::Isometry3f& T_into_from,
                                 float voxel_m);

/// What two volumes say about the surfaces of the place that both know.
struct SurfaceAgreement {
  int num_both = 0;  ///< blocks with surfaces of either where the other knows what is there
  int num_same = 0;  ///< of these, the blocks whose surface the other shows within two voxels

  /// Share of the blocks that show one surface; 1 when nothing is known to both.
  [[nodiscard]] double share_same() const {
    return num_both > 0 ? static_cast<double>(num_same) / num_both : 1;
  }
};

/// Looks for the surfaces of each in the other, from a fifth of the occupied voxels of some 4,000 blocks. A surface that
/// lies where the other has seen nothing says nothing. No allocation.
/// @param T_b_a  pose of a's frame in b's
[[nodiscard]] SurfaceAgreement compare_surfaces(const VoxelStore& store, const Volume& a,
                                                const Volume& b, const Pose& T_b_a,
                                                double voxel_size_m);

}  // namespace cloister
