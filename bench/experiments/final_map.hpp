#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mapping/core/result.hpp"

namespace cloister {

/// Two final submaps that know much of the same space.
struct RemainingPair {
  std::int64_t a = 0, b = 0;
  std::int64_t root_a = 0, root_b = 0;  ///< graph nodes; negative where a submap has none
  double overlap = 0.0;                 ///< the larger of both voxel overlap ratios
};

/// Pairs of submaps of a saved map whose voxel overlap is above `min_overlap`. Errors: those of load_map
[[nodiscard]] Result<std::vector<RemainingPair>> find_remaining_pairs(
    const std::filesystem::path& map, double min_overlap);

/// How many returns are taken.
struct ReturnSampling {
  int every_scan = 5;
  int every_pixel = 211;
};

/// Writes a mission's returns, placed by the poses that the replay settled on, as float x y z in M, little-endian. The
/// sensor's motion within a scan is the odometry's. Scans that the replay did not integrate are passed over.
/// @param trajectory  OUT/trajectory.tum: sensor in M at every integrated scan
/// @return how many returns. Errors: kInput naming the file; kResource when `file` cannot be written
[[nodiscard]] Result<std::size_t> write_placed_returns(const std::filesystem::path& mission,
                                                       const std::filesystem::path& trajectory,
                                                       const ReturnSampling& sampling,
                                                       const std::filesystem::path& file);

}  // namespace cloister
