#pragma once

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// Where a body was at a stamp, as odometry tells it.
struct StampedPose {
  SensorTime stamp;
  /// Pose of the body frame: the sensor's, unless the mission says otherwise.
  Pose T_O_B = Pose::Identity();
};

}  // namespace cloister
