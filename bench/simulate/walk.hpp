#pragma once

#include <cstdint>
#include <span>

#include "bench/simulate/trajectory.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// How a person or a legged robot carries the sensor.
struct WalkConfig {
  double speed_mps = 1.0;
  double stairs_speed_mps = 0.65;
  double acceleration_mps2 = 0.9;
  double max_yaw_rate_radps = 1.5;
  double corner_m = 0.18;     ///< width of the Gaussian that rounds the path's corners
  double rest_s = 1.0;        ///< standing still at the beginning and at the end
  double shake_m = 0.004;     ///< amplitude of the steps, at full speed
  double shake_rad = 0.0175;  ///< amplitude of pitch and roll, at full speed
  double shake_hz = 2.0;
};

/// Walks through the waypoints: corners rounded, slower in bends, on slopes and before pauses, the
/// x axis of the sensor looking along the path, with the shake of steps on top. At least two
/// waypoints in different places.
/// @return T_W_L at 100 Hz
[[nodiscard]] Trajectory walk(std::span<const Waypoint> path, const WalkConfig& config,
                              SensorTime start, std::uint64_t seed);

/// Resamples recorded poses to 100 Hz, beginning at `start`.
[[nodiscard]] Trajectory resample(const std::vector<StampedPose>& poses, SensorTime start);

}  // namespace cloister
