#include "mapping/fuse/block_sampler.hpp"

#include <algorithm>
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

BlockRange padded_blocks(const CornerRange& range, double margin_vox) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(margin_vox);
  return {block_at(range.low - margin), block_at(range.high + margin)};
}

}  // namespace

BlockRange blocks_under(const BlockCoord& block_A, const Pose& T_B_A, double voxel_size_m) {
  return padded_blocks(centre_range(block_A, T_B_A.linear(), T_B_A.translation() / voxel_size_m), kMarginVox);
}

BlockSampler::BlockSampler(const VoxelStore& store, const Volume& volume_B, const Pose& T_B_A,
                           double voxel_size_m, int highest)
    : store_(store),
      volume_(volume_B),
      axis_x_(T_B_A.linear().col(0).cast<float>()),
      axis_y_(T_B_A.linear().col(1).cast<float>()),
      axis_z_(T_B_A.linear().col(2).cast<float>()),
      R_B_A_(T_B_A.linear()),
      offset_(T_B_A.translation() / voxel_size_m),
      highest_(highest) {}

bool BlockSampler::grids_agree() const {
  return R_B_A_.isIdentity(1e-9) &&
         (offset_.array() - offset_.array().round()).abs().maxCoeff() < 1e-6;
}

std::optional<LogOdds> BlockSampler::gather(const BlockCoord& block_A) {
  const CornerRange centres = centre_range(block_A, R_B_A_, offset_);
  const BlockRange under = padded_blocks(centres, kMarginVox);
  // The eight voxels around a centre lie half a voxel further.
  const BlockRange around = padded_blocks(centres, 0.5 + kMarginVox);
  low_ = around.low;
  size_ = around.high - around.low + Eigen::Vector3i::Ones();
  // From the lowest gathered block: far from B's origin single precision would miss the gathered blocks.
  base_ = (R_B_A_ * (block_A.cast<double>() * kBlockEdge + Eigen::Vector3d::Constant(0.5)) +
           offset_ - low_.cast<double>() * kBlockEdge)
              .cast<float>();
  std::optional<LogOdds> uniform = volume_.view(store_, under.low).coarse;
  BlockView* view = views_.data();
  for (int z = around.low.z(); z <= around.high.z(); ++z) {
    for (int y = around.low.y(); y <= around.high.y(); ++y) {
      for (int x = around.low.x(); x <= around.high.x(); ++x, ++view) {
        const BlockCoord coord(x, y, z);
        *view = volume_.view(store_, coord);
        const bool is_under = (coord.array() >= under.low.array()).all() &&
                              (coord.array() <= under.high.array()).all();
        if (is_under && !(view->is_uniform() && view->coarse == uniform)) uniform.reset();
      }
    }
  }
  return uniform;
}

LogOdds BlockSampler::weighed_at(int x, int y, int z) const {
  // From the middles of voxels: a whole number is where one voxel's word counts alone.
  const Eigen::Vector3f p_low = centre(x, y, z) - Eigen::Vector3f::Constant(0.5f);
  const VoxelCoord low(floor(p_low.x()), floor(p_low.y()), floor(p_low.z()));
  const Eigen::Vector3f upper_weight = p_low - low.cast<float>();
  float sum = 0, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const VoxelCoord step(corner & 1, corner >> 1 & 1, corner >> 2);
    const LogOdds value = value_at(low + step);
    if (value == kUnknownLogOdds) continue;
    float weight = 1;
    for (int axis = 0; axis < 3; ++axis)
      weight *= step[axis] == 1 ? upper_weight[axis] : 1 - upper_weight[axis];
    // Occupied voxels go higher than free ones go low: equally sure ones must count alike, or surfaces would grow.
    sum += weight * static_cast<float>(std::min<int>(value, highest_));
    weights += weight;
  }
  return weights > 0 ? static_cast<LogOdds>(std::lround(sum / weights)) : kUnknownLogOdds;
}

}  // namespace cloister
