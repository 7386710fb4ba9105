#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Looks up voxels of a volume B at the places of another grid A, block by block: for each voxel centre of A the nearest
/// voxel of B, or what the eight around it say together. What a block of A can reach of B, at most 4x4x4 blocks, `gather`
/// fetches once.
///
/// When both grids agree (no rotation, whole voxels apart) the lookup is exact.
class BlockSampler {
 public:
  /// @param T_B_A    pose of A's frame in B's, metres
  /// @param highest  occupied voxels weigh no more than this among eight, in steps: as sure as free ones can be
  BlockSampler(const VoxelStore& store, const Volume& volume_B, const Pose& T_B_A,
               double voxel_size_m, int highest);

  /// True when one grid's voxels are the other's: then there is nothing to weigh.
  [[nodiscard]] bool grids_agree() const;

  /// Fetches what lies under a block of A.
  /// @return the one value that B has everywhere under it, when B is uniform there
  std::optional<LogOdds> gather(const BlockCoord& block_A);

  /// B's value under a voxel of the gathered block; x, y, z in 0..7.
  [[nodiscard]] LogOdds at(int x, int y, int z) const {
    const Eigen::Vector3f p_low = centre(x, y, z);
    return value_at({floor(p_low.x()), floor(p_low.y()), floor(p_low.z())});
  }
  /// What the known ones of the nearest eight voxels of B say, weighed by their nearness; kUnknownLogOdds when none is
  /// known, or when their evidence cancels out.
  [[nodiscard]] LogOdds weighed_at(int x, int y, int z) const;

 private:
  /// Of a voxel of the gathered block, in voxels of B from low_.
  [[nodiscard]] Eigen::Vector3f centre(int x, int y, int z) const {
    return base_ + axis_x_ * static_cast<float>(x) + axis_y_ * static_cast<float>(y) +
           axis_z_ * static_cast<float>(z);
  }
  [[nodiscard]] static int floor(float value) { return static_cast<int>(std::floor(value)); }
  [[nodiscard]] LogOdds value_at(const VoxelCoord& v) const {
    const int index = (v.x() >> kBlockShift) +
                      size_.x() * ((v.y() >> kBlockShift) + size_.y() * (v.z() >> kBlockShift));
    return views_[index].at(index_in_block(v));
  }

  const VoxelStore& store_;
  const Volume& volume_;
  Eigen::Vector3f axis_x_, axis_y_, axis_z_;  ///< steps in B (voxels) for one voxel along A's axes
  Eigen::Matrix3d R_B_A_;
  Eigen::Vector3d offset_;  ///< A's origin in B, voxels
  Eigen::Vector3f base_;    ///< centre of the gathered block's first voxel, voxels of B from low_
  int highest_;
  BlockCoord low_;
  Eigen::Vector3i size_;
  std::array<BlockView, 64> views_;
};

/// Blocks of B that a block of A can reach into: inclusive bounds.
struct BlockRange {
  BlockCoord low;
  BlockCoord high;
};
[[nodiscard]] BlockRange blocks_under(const BlockCoord& block_A, const Pose& T_B_A,
                                      double voxel_size_m);

}  // namespace cloister
