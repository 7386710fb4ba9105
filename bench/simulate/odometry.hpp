#pragma once

#include <cstdint>

#include "bench/simulate/trajectory.hpp"

namespace cloister {

/// How odometry errs. The parts grow with the distance walked, not with time: an estimator that
/// uses the lidar does not drift while it stands. Roll and pitch are seen through gravity and only
/// wobble.
struct DriftConfig {
  double percent = 0.5;  ///< rms position error after 20 m of straight way, in per cent of it;
                         ///< scales all parts below

  double scale = 0.003;                ///< standard deviation of the scale error at 0.5 per cent
  double walk_m_per_sqrt_m = 0.012;    ///< random walk along x and y
  double climb_m_per_sqrt_m = 0.005;   ///< random walk along z
  double yaw_rad_per_sqrt_m = 0.0009;  ///< random walk of the heading
  double tilt_rad = 0.0005;            ///< wobble of roll and pitch

  /// The parts' common factor.
  [[nodiscard]] double factor() const { return percent / 0.5; }
};

/// Corrupts a true trajectory T_W_L. @return T_O_L, same stamps, the identity at the first one
[[nodiscard]] Trajectory corrupt(const Trajectory& truth, const DriftConfig& drift,
                                 std::uint64_t seed);

}  // namespace cloister
