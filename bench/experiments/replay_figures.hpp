#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// The map as it stood after one scan.
struct MapSize {
  SensorTime stamp;
  std::int64_t submaps = 0;
  std::int64_t bytes = 0;
};

/// CPU seconds of a replay, stage by stage.
struct StageCpu {
  double decode_s = 0.0;
  double spawn_check_s = 0.0;
  double integration_s = 0.0;
  double overlap_s = 0.0;
  double uncertainty_s = 0.0;
  double fusion_s = 0.0;
  double total_s = 0.0;
};

/// What a replay says about itself in summary.json and timeline.csv.
struct ReplayFigures {
  std::int64_t scans = 0;
  double duration_s = 0.0;
  double travel_m = 0.0;
  std::int64_t submaps_spawned = 0;
  std::int64_t submaps_peak = 0;
  std::int64_t submaps_final = 0;
  std::int64_t map_bytes_peak = 0;
  std::int64_t map_bytes_final = 0;
  double integrate_p50_ms = 0.0;
  double integrate_p99_ms = 0.0;
  double latency_p50_ms = 0.0;
  double latency_p99_ms = 0.0;
  double overlap_p99_ms = 0.0;
  StageCpu cpu;
  double max_sigma_m = 0.0;     ///< fusion.max_sigma_m, the doubt up to which pairs are fused
  std::vector<MapSize> growth;  ///< rising stamps
};

/// Reads OUT/summary.json and OUT/timeline.csv. Errors: kInput with file and key, or file:line
[[nodiscard]] Result<ReplayFigures> read_replay(const std::filesystem::path& out);

/// Rows of a timeline, columns found by name. Errors: kInput with file:line for a missing column, a short row, a cell
/// that is no number, or a stamp that does not rise
[[nodiscard]] Result<std::vector<MapSize>> parse_timeline(std::string_view csv,
                                                          std::string_view file_name);

/// The map's bytes after the last scan that is not younger than `stamp`; 0 before the first.
[[nodiscard]] std::int64_t map_bytes_at(const std::vector<MapSize>& growth, SensorTime stamp);

/// How much the last third of the mission adds to the map: bytes at the end over bytes at two thirds, less one.
[[nodiscard]] double growth_in_last_third(const std::vector<MapSize>& growth);

}  // namespace cloister
