#include "mapping/fuse/same_surface.hpp"

#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

// How far apart along an axis two submaps may see one surface: what a fusion allows the graph not to know.
constexpr int kSameSurfaceVox = 3;
// Of a block's occupied voxels one in so many is looked for, and half of those must be found.
constexpr int kSurfaceStride = 5;
constexpr std::int64_t kMinKnownDivisor = 2;

}  // namespace

bool knows_block(const VoxelStore& store, const BlockView& view, const Volume& into,
                 const Eigen::Vector3f& middle_into, float block_m) {
  const BlockView held =
      into.view(store, (middle_into / block_m).array().floor().matrix().cast<int>());
  return !held.is_unknown() && kMinKnownDivisor * count_known(held) >= count_known(view);
}

bool shows_same_surface(const VoxelStore& store, const BlockCoord& coord, const BlockView& view,
                        const Volume& into, const Eigen::Isometry3f& T_into_from, float voxel_m) {
  if (view.block == nullptr && view.coarse <= 0) return true;
  const auto is_occupied_near = [&](const VoxelCoord& voxel) {
    if (into.at(store, voxel) > 0) return true;
    for (int axis = 0; axis < 3; ++axis) {
      for (int step = 1; step <= kSameSurfaceVox; ++step) {
        const VoxelCoord aside = step * VoxelCoord::Unit(axis);
        if (into.at(store, voxel + aside) > 0 || into.at(store, voxel - aside) > 0) return true;
      }
    }
    return false;
  };
  int num_occupied = 0, num_asked = 0, num_found = 0;
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (view.at(i) <= 0 || num_occupied++ % kSurfaceStride != 0) continue;
    const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
    const Eigen::Vector3f p_into =
        T_into_from * Eigen::Vector3f((voxel.cast<float>().array() + 0.5f).matrix() * voxel_m);
    ++num_asked;
    num_found += is_occupied_near((p_into / voxel_m).array().floor().matrix().cast<int>());
  }
  return 2 * num_found >= num_asked;
}

double same_surface_share(const VoxelStore& store, const Volume& a, const Volume& b,
                          const Pose& T_b_a, double voxel_size_m) {
  const Eigen::Isometry3f T = T_b_a.cast<float>();
  const auto voxel_m = static_cast<float>(voxel_size_m);
  int num_both = 0, num_same = 0;
  a.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    if (view.block == nullptr) return;
    const Eigen::Vector3f middle_b =
        T * Eigen::Vector3f((coord.cast<float>().array() + 0.5f).matrix() * kBlockEdge * voxel_m);
    if (!knows_block(store, view, b, middle_b, kBlockEdge * voxel_m)) return;
    ++num_both;
    num_same += shows_same_surface(store, coord, view, b, T, voxel_m);
  });
  return num_both > 0 ? static_cast<double>(num_same) / num_both : 1;
}

}  // namespace cloister
