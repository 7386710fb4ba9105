#pragma once

#include <cstddef>

#include "mapping/core/config.hpp"
#include "mapping/integrate/ray_marker.hpp"
#include "mapping/scan/deskew.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// What integrating one scan did, in numbers.
struct IntegrationResult {
  std::size_t blocks_touched = 0;
  std::size_t voxels_declined = 0;  ///< updates that a full pool or window did not take
};

/// Adds scans to a volume: log-odds go up where a beam ends and down where it passed; a voxel that a scan both hits
/// and crosses counts as hit. Free space stays in coarse nodes: an unknown block that is crossed everywhere becomes
/// one, a free one is updated as a whole when a scan crosses at least half of it, and left alone otherwise.
///
/// Threads: one owner, who also owns the volume and the pools.
/// Real-time: no allocation, lock or system call after construction; O(rays * range / voxel).
class ScanIntegrator {
 public:
  explicit ScanIntegrator(const VoxelConfig& config);

  IntegrationResult integrate(const RayBundle& bundle, const Eigen::Vector3f& sensor_S, VoxelPools& pools,
                              Volume& volume);

 private:
  [[nodiscard]] std::size_t apply(const RayMarker::Marked& marked, VoxelPools& pools, Volume& volume) const;

  RayMarker marker_;
  int hit_;
  int miss_;
  int lowest_;
  int highest_;
};

/// Sum of two observations within limits; what cancels exactly keeps the sign of `evidence`.
[[nodiscard]] constexpr LogOdds add_log_odds(int value, int evidence, int lowest, int highest) {
  const int sum = value + evidence;
  const int kept = sum < lowest ? lowest : sum > highest ? highest : sum;
  return static_cast<LogOdds>(kept != 0 ? kept : evidence < 0 ? -1 : evidence > 0 ? 1 : 0);
}

}  // namespace cloister
