#include "mapping/fuse/same_surface.hpp"

#include <cstddef>
#include <optional>

#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

// How far apart along an axis two submaps may see one surface: in a single block, what a fusion allows the graph not to
// know; in most blocks of a place, less, for then its walls would stand twice.
constexpr int kSameSurfaceVox = 3;
constexpr int kSamePlaceVox = 2;
// Of a block's occupied voxels one in so many is looked for, and half of those must be found.
constexpr int kSurfaceStride = 5;
// Of a large volume so many blocks tell.
constexpr std::size_t kMaxBlocksAsked = 4'000;

VoxelCoord voxel_of_block(const BlockCoord& coord, int i) {
  return coord * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
}

/// Where the middle of a voxel lies in another volume, in voxels.
Eigen::Vector3f centre_under(const VoxelCoord& voxel, const Eigen::Isometry3f& T_into_from, float voxel_m) {
  return T_into_from * Eigen::Vector3f((voxel.cast<float>().array() + 0.5f).matrix() * voxel_m) / voxel_m;
}
VoxelCoord voxel_at(const Eigen::Vector3f& p_vox) { return p_vox.array().floor().matrix().cast<int>(); }
/// The voxel of another volume in which the middle of one lies.
VoxelCoord voxel_under(const VoxelCoord& voxel, const Eigen::Isometry3f& T_into_from, float voxel_m) {
  return voxel_at(centre_under(voxel, T_into_from, voxel_m));
}

/// How many voxels along an axis the nearest occupied one is away; kSameSurfaceVox + 1 when it is further.
int steps_to_occupied(const VoxelStore& store, const Volume& volume, const VoxelCoord& voxel) {
  if (volume.at(store, voxel) > 0) return 0;
  for (int step = 1; step <= kSameSurfaceVox; ++step) {
    for (int axis = 0; axis < 3; ++axis) {
      const VoxelCoord aside = step * VoxelCoord::Unit(axis);
      if (volume.at(store, voxel + aside) > 0 || volume.at(store, voxel - aside) > 0) return step;
    }
  }
  return kSameSurfaceVox + 1;
}

/// True when a volume goes from free to occupied where a surface is said to be, along a line that comes from before it.
bool has_surface(const VoxelStore& store, const Volume& volume, const Eigen::Vector3f& p_vox,
                 const Eigen::Vector3f& outwards) {
  bool is_before_free = false;
  for (float along = kSamePlaceVox + 1; along >= -kSamePlaceVox; along -= 0.5f) {
    const LogOdds value = volume.at(store, voxel_at(p_vox + along * outwards));
    if (value > 0) return is_before_free;
    is_before_free = value < 0;
  }
  return false;
}

/// Of occupied voxels that were looked for in the other volume, how many it has, and how near.
struct Found {
  int asked = 0, near = 0, adjacent = 0;

  void count(int steps) {
    ++asked;
    near += steps <= kSameSurfaceVox;
    adjacent += steps <= 1;
  }
};

/// Does another volume show a block's surface within two voxels? Only voxels of which it knows something are asked:
/// far away surfaces are rows of returns with nothing known between them, and those of two views need not meet.
/// @return nothing when no such voxel is there
std::optional<bool> shows_surface(const VoxelStore& store, const BlockCoord& coord,
                                  const BlockView& view, const Volume& into,
                                  const Eigen::Isometry3f& T_into_from, float voxel_m) {
  int num_occupied = 0, num_asked = 0, num_found = 0;
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (view.at(i) <= 0 || num_occupied++ % kSurfaceStride != 0) continue;
    const VoxelCoord voxel_into = voxel_under(voxel_of_block(coord, i), T_into_from, voxel_m);
    const bool is_found = steps_to_occupied(store, into, voxel_into) <= kSamePlaceVox;
    num_found += is_found;
    num_asked += is_found || into.at(store, voxel_into) != kUnknownLogOdds;
  }
  if (num_asked == 0) return std::nullopt;
  return 2 * num_found >= num_asked;
}

/// Looks for a's surfaces in b.
SurfaceAgreement find_surfaces(const VoxelStore& store, const Volume& a, const Volume& b,
                               const Eigen::Isometry3f& T_b_a, float voxel_m) {
  SurfaceAgreement agreement;
  // By their coordinates: the order in which a volume has its blocks must not count.
  const int stride = static_cast<int>(a.num_blocks() / kMaxBlocksAsked) + 1;
  a.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    if (view.block == nullptr || (coord.x() + 3 * coord.y() + 7 * coord.z()) % stride != 0) return;
    const Eigen::Vector3f middle_b =
        T_b_a *
        Eigen::Vector3f((coord.cast<float>().array() + 0.5f).matrix() * kBlockEdge * voxel_m);
    if (known_ratio(store, view, b, middle_b, kBlockEdge * voxel_m) < kMinKnownRatio) return;
    const std::optional<bool> is_same = shows_surface(store, coord, view, b, T_b_a, voxel_m);
    agreement.num_both += is_same.has_value();
    agreement.num_same += is_same.value_or(false);
  });
  return agreement;
}

}  // namespace

BlockAgreement compare_block(const VoxelStore& store, const BlockCoord& coord,
                             const BlockView& view, const Volume& from, const Volume& into,
                             const Eigen::Isometry3f& T_into_from, float voxel_m) {
  Found ours, theirs;
  int num_known = 0, num_both = 0, num_occupied = 0;
  for (int i = 0; i < kBlockVoxels; ++i) {
    const LogOdds value = view.at(i);
    if (value == kUnknownLogOdds) continue;
    const bool is_asked =
        value > 0 ? num_occupied++ % kSurfaceStride == 0 : i % kSurfaceStride == 0;
    if (!is_asked) continue;
    const VoxelCoord voxel = voxel_of_block(coord, i);
    const VoxelCoord voxel_into = voxel_under(voxel, T_into_from, voxel_m);
    const LogOdds value_into = into.at(store, voxel_into);
    ++num_known;
    num_both += value_into != kUnknownLogOdds;
    if (value > 0) {
      ours.count(steps_to_occupied(store, into, voxel_into));
    } else if (value_into > 0) {
      theirs.count(steps_to_occupied(store, from, voxel));
    }
  }
  return {.share_same = ours.asked > 0 ? static_cast<double>(ours.near) / ours.asked : 1,
          .is_aligned = 2 * ours.adjacent >= ours.asked && 2 * theirs.adjacent >= theirs.asked,
          .share_known = num_known > 0 ? static_cast<double>(num_both) / num_known : 1};
}

double share_shown(const VoxelStore& store, const BlockCoord& coord, const BlockView& view, const Volume& from,
                   const Volume& into, const Eigen::Isometry3f& T_into_from, float voxel_m) {
  int num_occupied = 0, num_near = 0, num_front = 0, num_shown = 0;
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (view.at(i) <= 0) continue;
    const VoxelCoord voxel = voxel_of_block(coord, i);
    const Eigen::Vector3f p_vox = centre_under(voxel, T_into_from, voxel_m);
    ++num_occupied;
    num_near += steps_to_occupied(store, into, voxel_at(p_vox)) <= kSamePlaceVox;
    bool is_front = false, is_shown = false;
    for (int face = 0; face < 6 && !is_shown; ++face) {
      const VoxelCoord outwards = (face % 2 == 0 ? 1 : -1) * VoxelCoord::Unit(face / 2);
      if (from.at(store, voxel + outwards) >= 0) continue;
      is_front = true;
      is_shown = has_surface(store, into, p_vox, T_into_from.linear() * outwards.cast<float>());
    }
    num_front += is_front;
    num_shown += is_shown;
  }
  if (num_front > 0) return static_cast<double>(num_shown) / num_front;
  return num_occupied > 0 ? static_cast<double>(num_near) / num_occupied : 1;
}

double known_ratio(const VoxelStore& store, const BlockView& view, const Volume& into,
                   const Eigen::Vector3f& middle_into, float block_m) {
  const BlockView held =
      into.view(store, (middle_into / block_m).array().floor().matrix().cast<int>());
  if (held.is_unknown()) return 0;
  return static_cast<double>(count_known(held)) / static_cast<double>(count_known(view));
}

SurfaceAgreement compare_surfaces(const VoxelStore& store, const Volume& a, const Volume& b,
                                  const Pose& T_b_a, double voxel_size_m) {
  const auto voxel_m = static_cast<float>(voxel_size_m);
  const SurfaceAgreement of_a = find_surfaces(store, a, b, T_b_a.cast<float>(), voxel_m);
  const SurfaceAgreement of_b = find_surfaces(store, b, a, T_b_a.inverse().cast<float>(), voxel_m);
  return {of_a.num_both + of_b.num_both, of_a.num_same + of_b.num_same};
}

}  // namespace cloister
