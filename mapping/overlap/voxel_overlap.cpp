#include "mapping/overlap/voxel_overlap.hpp"

#include <algorithm>
#include <bit>

#include "mapping/overlap/block_sampler.hpp"

namespace cloister {

std::int64_t count_known(const BlockView& view) {
  if (view.block == nullptr) return std::popcount(view.known) * kOctantVoxels;
  return kBlockVoxels - std::count(std::begin(view.block->voxels), std::end(view.block->voxels), kUnknownLogOdds);
}

std::int64_t count_known(const VoxelStore& store, const Volume& volume) {
  std::int64_t known = 0;
  volume.for_each_block(store, [&](const BlockCoord&, const BlockView& view) { known += count_known(view); });
  return known;
}

Eigen::AlignedBox3d known_bounds(const VoxelStore& store, const Volume& volume, double voxel_size_m) {
  Eigen::AlignedBox3i blocks;
  volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    if (count_known(view) > 0) blocks.extend(coord);
  });
  if (blocks.isEmpty()) return {};
  const double edge_m = voxel_size_m * kBlockEdge;
  return {blocks.min().cast<double>() * edge_m, (blocks.max() + BlockCoord::Ones()).cast<double>() * edge_m};
}

VoxelOverlap voxel_overlap(const VoxelStore& store, const Volume& a, const Volume& b, const Pose& T_b_a,
                           double voxel_size_m) {
  VoxelOverlap overlap;
  overlap.num_known_b = count_known(store, b);
  BlockSampler sampler(store, b, T_b_a, voxel_size_m);
  a.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    const std::int64_t known = count_known(view);
    overlap.num_known_a += known;
    if (known == 0) return;
    const std::optional<LogOdds> under = sampler.gather(coord);
    if (under && *under == kUnknownLogOdds) return;
    if (under && view.block == nullptr) {
      overlap.num_agreeing += state_of(*under) == state_of(view.coarse) ? known : 0;
      return;
    }
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y) {
        for (int x = 0; x < kBlockEdge; ++x) {
          const LogOdds value_a = view.at(index_in_block(x, y, z));
          if (value_a == kUnknownLogOdds) continue;
          const LogOdds value_b = under ? *under : sampler.at(x, y, z);
          overlap.num_agreeing += state_of(value_a) == state_of(value_b);
        }
      }
    }
  });
  return overlap;
}

}  // namespace cloister
