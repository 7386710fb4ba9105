#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mapping/submap/evidence_sum.hpp"
#include "mapping/submap/submap.hpp"
#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// What the map says about the space that a body takes.
struct HullAnswer {
  VoxelState state = VoxelState::kFree;
  /// Centre of the voxel that decided, in M; meaningless when the space is free.
  Eigen::Vector3d where_M = Eigen::Vector3d::Zero();
  SubmapId submap = kNoSubmap;  ///< whose voxel that is; none when nobody knows it
};

/// Does a convex body at some place touch anything occupied, or anything that nobody has seen?
///
/// Occupied: the body touches an occupied voxel of some submap, in that submap's own grid, and all submaps together
/// hold the voxel's centre to be occupied. Unknown: nothing occupied, but the body touches a voxel of the grid that is
/// parallel to M's axes whose centre no submap knows. Free: neither. Touching counts; where rounding cannot tell, the
/// body touches.
///
/// Whole blocks of coarse free space are passed over, and the exact test (HullTest) is made for voxels
/// that would decide, so that free space costs look-ups alone.
///
/// The submaps must stay as they are while the query lives.
/// Threads: one at a time. Allocates at construction; `at` does not, once it has seen as many corners.
class HullQuery {
 public:
  /// Bodies whose bounds hold more voxels are refused: ~20 m^3 at 6.5 cm.
  static constexpr std::size_t kMaxVoxels = 75'000;
  static constexpr std::size_t kMaxCorners = 64;

  /// @param lowest, highest  bounds of the combined evidence
  HullQuery(const VoxelStore& store, double voxel_size_m, LogOdds lowest, LogOdds highest,
            std::span<const Submap* const> submaps);

  /// @param corners_M  of the convex hull, metres, up to kMaxCorners, in any order
  /// @return nothing when there are no corners or too many, one is not finite, or the body is too large
  [[nodiscard]] std::optional<HullAnswer> at(std::span<const Eigen::Vector3d> corners_M);

 private:
  struct Entry {
    const Submap* submap = nullptr;
    Pose T_S_M = Pose::Identity();
    Eigen::AlignedBox3d bounds_S;  ///< of what it knows
    // The block that was looked at last.
    bool has_view = false;
    BlockCoord viewed = BlockCoord::Zero();
    BlockView view = {};
  };

  [[nodiscard]] QueryAnswer combined(const Eigen::Vector3d& p_M) const;
  [[nodiscard]] bool find_occupied(const Entry& entry, HullAnswer& answer) const;
  [[nodiscard]] bool find_unknown(std::span<const Eigen::Vector3d> corners_M, HullAnswer& answer);
  /// Whether any submap knows the voxel at a point.
  [[nodiscard]] bool is_known(const Eigen::Vector3d& p_M);
  /// True when one submap knows all of a block of M's grid by coarse nodes.
  [[nodiscard]] bool is_coarsely_known(const Eigen::AlignedBox3d& block_M) const;

  const VoxelStore& store_;
  double voxel_size_m_;
  LogOdds lowest_, highest_;
  std::vector<Entry> all_;
  std::vector<Entry*> near_;  ///< those whose bounds meet the body's
  std::vector<Eigen::Vector3d> corners_S_;
};

}  // namespace cloister
