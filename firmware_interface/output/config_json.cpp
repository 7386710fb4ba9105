#include "firmware_interface/output/config_json.hpp"

namespace cloister {

nlohmann::ordered_json config_json(const Config& config) {
  const auto& [voxel, spawn, fusion, memory, scan, baseline] = config;
  nlohmann::ordered_json json;
  json["baseline"] = baseline;
  json["voxel"] = {{"voxel_size_m", voxel.voxel_size_m},   {"min_range_m", voxel.min_range_m},
                   {"max_range_m", voxel.max_range_m},     {"log_odds_hit", voxel.log_odds_hit},
                   {"log_odds_miss", voxel.log_odds_miss}, {"log_odds_min", voxel.log_odds_min},
                   {"log_odds_max", voxel.log_odds_max}};
  json["spawn"] = {{"min_overlap", spawn.min_overlap},
                   {"filter_m", spawn.filter_m},
                   {"cloud_lag_m", spawn.cloud_lag_m},
                   {"max_correction_m", spawn.max_correction_m},
                   {"baseline_distance_m", spawn.baseline_distance_m}};
  json["fusion"] = {{"min_overlap", fusion.min_overlap},
                    {"min_overlap_loop", fusion.min_overlap_loop},
                    {"max_sigma_m", fusion.max_sigma_m},
                    {"max_sigma_unlooped_m", fusion.max_sigma_unlooped_m},
                    {"default_information", fusion.default_information}};
  json["memory"] = {{"budget_bytes", memory.budget_bytes},
                    {"max_submaps", memory.max_submaps},
                    {"max_cloud_points", memory.max_cloud_points}};
  json["scan"] = {{"max_points", scan.max_points},
                  {"max_odometry_gap_s", scan.max_odometry_gap_s},
                  {"max_odometry_wait_s", scan.max_odometry_wait_s},
                  {"stamp_offset_s", scan.stamp_offset_s}};
  return json;
}

}  // namespace cloister
