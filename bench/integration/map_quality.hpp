#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "bench/integration/placed_scan.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What a map says about a point in S.
using StateAt = std::function<VoxelState(const Eigen::Vector3f& p_S)>;

/// How often a map gave each answer.
struct StateCounts {
  std::array<std::size_t, 3> counts{};  ///< by VoxelState

  void add(VoxelState state) { ++counts[static_cast<std::size_t>(state)]; }
  [[nodiscard]] std::size_t total() const { return counts[0] + counts[1] + counts[2]; }
  /// 0 when nothing was asked.
  [[nodiscard]] double share(VoxelState state) const;
};

/// How a map agrees with scans that it has not seen.
struct BeamQuality {
  static constexpr std::array<float, 5> kRangeLimitsM = {0.5f, 5, 15, 30, 60};

  StateCounts
      before_end;  ///< points at 10, 15 .. 95 % of a beam, more than three voxels before its end
  /// The end of a beam: occupied when the map is within one voxel along the beam, unknown when it knows none of the
  /// three points there, else free.
  StateCounts ends;
  std::array<StateCounts, 4>
      ends_by_range;        ///< between consecutive kRangeLimitsM; others are in `ends` alone
  StateCounts ground_ends;  ///< of `ends`, those with Beam::is_ground
};

/// Asks the map along one beam.
void judge_beam(const Beam& beam, float voxel_m, const StateAt& state_at, BeamQuality& quality);

/// A point at some distance from every surface, and what is truly there.
struct TruthPoint {
  Eigen::Vector3d p_A;  ///< in the frame of the truth
  bool is_solid = false;
};

/// How a map agrees with the simulated truth.
struct TruthQuality {
  StateCounts in_free_space;
  StateCounts in_solids;

  /// Of points that are truly free and known, the share called occupied; 0 when there are none.
  [[nodiscard]] double false_occupied() const;
  /// Of points that are truly inside solids, the share called free; 0 when there are none.
  [[nodiscard]] double false_free() const { return in_solids.share(VoxelState::kFree); }
};

/// @param origin_A  of S, which is parallel to A
[[nodiscard]] TruthQuality judge_points(const std::vector<TruthPoint>& points,
                                        const Eigen::Vector3d& origin_A, const StateAt& state_at);

}  // namespace cloister
