#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mapping/core/config.hpp"
#include "mapping/integrate/scan_integrator.hpp"
#include "mapping/scan/scan_beams.hpp"
#include "mapping/scan/scan.hpp"
#include "mapping/voxel/volume.hpp"
#include "runtime/memory_warmer.hpp"

namespace cloister {

/// Memory of one kind that a map holds.
struct ByteShare {
  std::string type;
  std::size_t count = 0;
  std::size_t bytes_each = 0;
};

/// One volume, filled scan by scan by the calls that LocalMapper makes. Everything the bench asks of the integrator
/// and of the volume is asked here.
class CloisterMap {
 public:
  /// @param budget_bytes  memory of the pools, taken here
  CloisterMap(const Config& config, std::size_t max_pixels, std::int64_t budget_bytes);

  /// @return blocks that the scan touched
  std::size_t integrate(const Scan& scan, const Pose& T_S_R) {
    place(scan, T_S_R);
    return integrate_placed();
  }
  // The same in two steps, for the kernels.
  void place(const Scan& scan, const Pose& T_S_R);
  std::size_t integrate_placed();
  /// What the pipeline's reader does between scans.
  void keep_memory_ahead() { warmer_.keep_ahead(pools_.blocks.num_used(), pools_.chunks.num_used()); }
  void clear() { volume_.clear(pools_); }

  [[nodiscard]] VoxelState state(const Eigen::Vector3f& p_S) const;
  [[nodiscard]] double observed_m3() const;
  /// As Submap counts it: what the pools handed out, and the volume's own table.
  [[nodiscard]] std::size_t bytes() const { return volume_.bytes(); }
  [[nodiscard]] std::vector<ByteShare> byte_shares() const;
  /// Updates that full pools did not take.
  [[nodiscard]] std::size_t num_declined() const { return num_declined_; }
  [[nodiscard]] const Volume& volume() const { return volume_; }
  [[nodiscard]] const VoxelStore& store() const { return store_; }
  [[nodiscard]] VoxelPools& pools() { return pools_; }

 private:
  VoxelConfig config_;
  VoxelStore store_;
  MemoryWarmer warmer_;
  VoxelPools pools_;
  Volume volume_;
  ScanBeams beams_;
  ScanIntegrator integrator_;
  Eigen::Vector3f sensor_S_ = Eigen::Vector3f::Zero();  ///< of the scan placed last
  std::size_t num_declined_ = 0;
};

}  // namespace cloister
