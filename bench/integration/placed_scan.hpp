#pragma once

#include <vector>

#include <Eigen/Core>

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// A scan and where its reference frame stood in S, the one frame of a bench run.
struct PlacedScan {
  Scan scan;
  Pose T_S_R = Pose::Identity();
};

/// One return after motion correction.
struct Beam {
  Eigen::Vector3f origin_S;
  Eigen::Vector3f end_S;
  bool is_ground = false;  ///< on a level surface below the sensor, as far as its neighbours tell
};

/// The sensor's pose in S at a stamp within the scan.
[[nodiscard]] Pose sensor_pose(const PlacedScan& placed, SensorTime stamp);

/// The scan's returns within the configured ranges, column by column, each placed by the sensor's pose at its own
/// column's stamp. Written for the bench alone, so that it judges what the integrator makes of the same packets.
/// @param stride  keep every stride-th pixel only
[[nodiscard]] std::vector<Beam> place_beams(const PlacedScan& placed, const VoxelConfig& config,
                                            int stride = 1);

}  // namespace cloister
