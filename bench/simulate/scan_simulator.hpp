#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bench/simulate/legacy_packet.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "bench/simulate/sensor_model.hpp"
#include "bench/simulate/trajectory.hpp"

namespace cloister {

/// Measures a world with a moving, spinning sensor: every column from where the sensor is at that
/// instant.
///
/// A range is the distance along the beam plus the beam origin's offset (that is how the sensor
/// reports it), plus noise. A pixel is empty when nothing is met within reach, when the target is
/// too close, when chance says so, or when too little light returns: by albedo, incidence and the
/// inverse square of the distance, against the distance at which the data sheet still sees a dark
/// target. Threads: const, may simulate several scans at once; every column draws noise from a
/// stream of its own.
class ScanSimulator {
 public:
  /// The mesh and scene must outlive the simulator.
  ScanSimulator(const SensorModel& sensor, const TriangleMesh& mesh, const RayScene& scene,
                std::uint64_t seed);

  /// Stamp of a column of the k-th scan, for a first scan that begins at `start`; exact for any
  /// number of scans.
  [[nodiscard]] SensorTime column_stamp(SensorTime start, std::uint64_t scan, int column) const;

  /// Simulates one revolution. @param truth T_W_L @param pixels [columns x beams], a column's beams
  /// together
  void simulate(const Trajectory& truth, SensorTime start, std::uint64_t scan,
                std::span<PixelReturn> pixels) const;

  [[nodiscard]] const SensorModel& sensor() const { return sensor_; }
  [[nodiscard]] std::size_t num_pixels() const { return fan_.directions_L.size(); }

 private:
  SensorModel sensor_;
  const TriangleMesh& mesh_;
  const RayScene& scene_;
  std::uint64_t seed_;
  BeamFan fan_;
};

}  // namespace cloister
