#pragma once

#include <limits>

#include "mapping/core/config.hpp"

namespace cloister {

/// Calls `visit(name, field, least, most)` for every field of a configuration (const or not): the one list that the
/// loader, the validation and the reports share. Bounds are inclusive; fields are double, int, std::int64_t or bool.
template <typename ConfigType, typename Visitor>
void visit_fields(ConfigType& config, Visitor&& visit) {
  constexpr double kMany = std::numeric_limits<std::int32_t>::max();
  auto& voxel = config.voxel;
  visit("voxel.voxel_size_m", voxel.voxel_size_m, 0.01, 1.0);
  visit("voxel.min_range_m", voxel.min_range_m, 0.0, 50.0);
  visit("voxel.max_range_m", voxel.max_range_m, 1.0, 300.0);
  visit("voxel.return_depth_m", voxel.return_depth_m, 0.0, 0.5);
  visit("voxel.log_odds_hit", voxel.log_odds_hit, 0.05, 6.0);
  visit("voxel.log_odds_miss", voxel.log_odds_miss, -6.0, -0.05);
  visit("voxel.log_odds_min", voxel.log_odds_min, -6.0, -0.05);
  visit("voxel.log_odds_max", voxel.log_odds_max, 0.05, 6.0);
  auto& spawn = config.spawn;
  visit("spawn.min_overlap", spawn.min_overlap, 0.0, 1.0);
  visit("spawn.min_scans", spawn.min_scans, 1, 1000);
  visit("spawn.filter_m", spawn.filter_m, 0.05, 5.0);
  visit("spawn.cloud_lag_m", spawn.cloud_lag_m, 0.0, 100.0);
  visit("spawn.max_threshold_m", spawn.max_threshold_m, 0.0, 100.0);
  visit("spawn.max_travel_m", spawn.max_travel_m, 0.0, 1e6);
  visit("spawn.min_covisibility", spawn.min_covisibility, 0.0, 1.0);
  visit("spawn.max_correction_m", spawn.max_correction_m, 0.001, 100.0);
  visit("spawn.baseline_distance_m", spawn.baseline_distance_m, 0.1, 1000.0);
  auto& fusion = config.fusion;
  visit("fusion.min_overlap", fusion.min_overlap, 0.0, 1.0);
  visit("fusion.min_shared_sight", fusion.min_shared_sight, 0.0, 1.0);
  visit("fusion.max_sigma_m", fusion.max_sigma_m, 0.0, 100.0);
  visit("fusion.max_sigma_unlooped_m", fusion.max_sigma_unlooped_m, 0.0, 100.0);
  visit("fusion.fuse_without_covariance", fusion.fuse_without_covariance, 0, 1);
  visit("fusion.default_information", fusion.default_information, 0.0, 1e12);
  auto& memory = config.memory;
  visit("memory.budget_bytes", memory.budget_bytes, 32.0 * (1 << 20), 1024.0 * (1 << 30));
  visit("memory.max_submaps", memory.max_submaps, 4, 65536);
  visit("memory.max_cloud_points", memory.max_cloud_points, 1000, kMany);
  auto& scan = config.scan;
  visit("scan.max_points", scan.max_points, 1024, 1 << 24);
  visit("scan.max_odometry_gap_s", scan.max_odometry_gap_s, 0.0, 60.0);
  visit("scan.max_odometry_wait_s", scan.max_odometry_wait_s, 0.0, 60.0);
  visit("scan.stamp_offset_s", scan.stamp_offset_s, -1e6, 1e6);
  visit("baseline", config.baseline, 0, 1);
}

}  // namespace cloister
