#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// How much two volumes see of the same space, and agree on it (paper, section III-B, algorithm 2).
struct VoxelOverlap {
  std::int64_t num_agreeing = 0;  ///< voxels of a that b knows in the same state
  std::int64_t num_known_a = 0;
  std::int64_t num_known_b = 0;

  [[nodiscard]] double ratio_a() const { return ratio(num_known_a); }
  [[nodiscard]] double ratio_b() const { return ratio(num_known_b); }

 private:
  [[nodiscard]] double ratio(std::int64_t known) const {
    return known > 0 ? static_cast<double>(num_agreeing) / static_cast<double>(known) : 0;
  }
};

/// Compares known voxels of `a` with the nearest voxels of `b`: all of them, in volumes of a few rooms. In larger ones, one
/// voxel of sixteen and one of each coarse node stand for the others: the numbers are then estimates, and the ratios right
/// to a few thousandths.
/// @param T_b_a  pose of a's frame in b's
/// Threads: both volumes must not change meanwhile. No allocation.
[[nodiscard]] VoxelOverlap voxel_overlap(const VoxelStore& store, const Volume& a, const Volume& b,
                                         const Pose& T_b_a, double voxel_size_m);

/// Voxels of a block's place that are free or occupied.
[[nodiscard]] std::int64_t count_known(const BlockView& view);
/// Voxels that are free or occupied.
[[nodiscard]] std::int64_t count_known(const VoxelStore& store, const Volume& volume);

/// Smallest box of whole blocks around what the volume knows, metres in S; empty for an empty volume.
[[nodiscard]] Eigen::AlignedBox3d known_bounds(const VoxelStore& store, const Volume& volume,
                                               double voxel_size_m);

}  // namespace cloister
