#include "mapping/fuse/block_sampler.hpp"

#include <cmath>

namespace cloister {
namespace {

struct CornerRange {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// Range of the images of a block's voxel centres, in voxels of B.
CornerRange centre_range(const BlockCoord& block_A, const Eigen::Matrix3d& R_B_A,
                         const Eigen::Vector3d& t_vox) {
  const Eigen::Vector3d middle =
      R_B_A * (block_A.cast<double>() * kBlockEdge + Eigen::Vector3d::Constant(0.5 * kBlockEdge)) +
      t_vox;
  const Eigen::Vector3d half = R_B_A.cwiseAbs() * Eigen::Vector3d::Constant(0.5 * (kBlockEdge - 1));
  return {middle - half, middle + half};
}

BlockCoord block_at(const Eigen::Vector3d& p_vox) {
  return {static_cast<int>(std::floor(p_vox.x())) >> kBlockShift,
          static_cast<int>(std::floor(p_vox.y())) >> kBlockShift,
          static_cast<int>(std::floor(p_vox.z())) >> kBlockShift};
}

// Rounding of a voxel centre in single precision must not leave the gathered blocks.
constexpr double kMarginVox = 0.01;

BlockRange padded_blocks(const CornerRange& range) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMarginVox);
  return {block_at(range.low - margin), block_at(range.high + margin)};
}

}  // namespace

BlockRange blocks_under(const BlockCoord& block_A, const Pose& T_B_A, double voxel_size_m) {
  return padded_blocks(centre_range(block_A, T_B_A.linear(), T_B_A.translation() / voxel_size_m));
}

BlockSampler::BlockSampler(const VoxelStore& store, const Volume& volume_B, const Pose& T_B_A,
                           double voxel_size_m)
    : store_(store),
      volume_(volume_B),
      axis_x_(T_B_A.linear().col(0).cast<float>()),
      axis_y_(T_B_A.linear().col(1).cast<float>()),
      axis_z_(T_B_A.linear().col(2).cast<float>()),
      R_B_A_(T_B_A.linear()),
      offset_(T_B_A.translation() / voxel_size_m) {}

std::optional<LogOdds> BlockSampler::gather(const BlockCoord& block_A) {
  const BlockRange range = padded_blocks(centre_range(block_A, R_B_A_, offset_));
  low_ = range.low;
  size_ = range.high - range.low + Eigen::Vector3i::Ones();
  // From the lowest gathered block: far from B's origin single precision would miss the gathered blocks.
  base_ = (R_B_A_ * (block_A.cast<double>() * kBlockEdge + Eigen::Vector3d::Constant(0.5)) +
           offset_ - low_.cast<double>() * kBlockEdge)
              .cast<float>();
  bool is_uniform = true;
  BlockView* view = views_.data();
  for (int z = 0; z < size_.z(); ++z) {
    for (int y = 0; y < size_.y(); ++y) {
      for (int x = 0; x < size_.x(); ++x, ++view) {
        *view = volume_.view(store_, low_ + BlockCoord(x, y, z));
        is_uniform &= view->is_uniform() && view->coarse == views_[0].coarse;
      }
    }
  }
  if (!is_uniform) return std::nullopt;
  return views_[0].coarse;
}

}  // namespace cloister
