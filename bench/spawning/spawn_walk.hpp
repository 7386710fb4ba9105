#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bench/simulate/scan_simulator.hpp"
#include "mapping/submap/local_mapper.hpp"

namespace cloister {

/// What a mapper made of a walk, submap by submap. One that begins only because the one before has become too long continues
/// it (Submap::continues), and counts as part of it.
struct SpawnedSubmap {
  SpawnReason reason = SpawnReason::kNone;
  double begins_at_m = 0.0;  ///< way of the sensor until its first scan
};

/// Carries a sensor through a world and hands its scans to a mapper as they come, placed by their true poses: no drift,
/// no graph, so that a submap begins only for what is seen, or for its length. Not copied or moved: the mapper points into it.
class SpawnWalk {
 public:
  /// @param sensor  its columns may be fewer than a real one's
  explicit SpawnWalk(const SensorModel& sensor, const Config& config = {});

  /// The k-th scan of a walk through a world. @param truth  T_W_L
  void scan(const TriangleMesh& mesh_W, const RayScene& scene_W, const Trajectory& truth,
            std::uint64_t k);
  /// All scans that fit into a walk.
  void scan_all(const TriangleMesh& mesh_W, const Trajectory& truth);

  [[nodiscard]] const std::vector<SpawnedSubmap>& submaps() const { return submaps_; }
  /// The shortest way between the beginnings of two submaps; infinite for one submap.
  [[nodiscard]] double shortest_submap_m() const;

 private:
  static constexpr int kMaxSubmaps = 64;

  SensorModel sensor_;
  Config config_;
  ScanGeometry geometry_;
  VoxelStore store_;
  LocalMapper mapper_;
  std::array<Submap, kMaxSubmaps> slots_;
  std::vector<PixelReturn> pixels_;
  Scan scan_;
  std::vector<SpawnedSubmap> submaps_;
  double travel_m_ = 0.0;
};

}  // namespace cloister
