#pragma once

#include <cstddef>
#include <optional>

#include "mapping/core/config.hpp"
#include "mapping/integrate/bare_turns.hpp"
#include "mapping/integrate/evidence.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/integrate/shared_scan.hpp"
#include "mapping/scan/scan_beams.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// What integrating one scan did, in numbers.
struct IntegrationResult {
  std::size_t blocks_hit = 0;       ///< with returns
  std::size_t blocks_free = 0;      ///< decided as wholes; 0 for rays
  std::size_t blocks_mixed = 0;     ///< looked into; for rays, all that were crossed
  std::size_t voxels_declined = 0;  ///< updates that a full pool or window did not take
};

/// Adds scans to a volume: log-odds go up where a beam ends and down where it passed; a voxel that a scan both hits
/// and crosses counts as hit. An organised scan is integrated coarse to fine from its range image (see
/// integrate_projective), any other beam by beam; both see a voxel at most once a scan.
///
/// Threads: one owner, who also owns the volume and the pools.
/// Real-time: no allocation, lock or system call after construction.
class ScanIntegrator {
 public:
  /// @param workers  share in every organised scan, with the same map as without; may be null
  explicit ScanIntegrator(const VoxelConfig& config, ScanWorkers* workers = nullptr);

  /// @param sensor_S  where the sensor was, to within a few metres
  IntegrationResult integrate(const ScanBeams& scan, const Eigen::Vector3f& sensor_S,
                              VoxelPools& pools, Volume& volume);

 private:
  VoxelConfig config_;
  Evidence evidence_;
  ScanMarks marks_;
  BareTurns bare_turns_;
  std::optional<SharedScan> shared_;
  std::uint64_t num_scans_ = 0;
};

}  // namespace cloister
