#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "bench/integration/map_quality.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// Asks cloister-bench-true-points, the program beside this one, for points of a simulated mission.
/// Errors: kResource when the program cannot be started or fails; kInput when its answer is malformed
[[nodiscard]] Result<std::vector<TruthPoint>> draw_truth_points(
    const std::filesystem::path& mission, std::size_t count);

/// Reads `x,y,z,solid` rows below a header; solid is 0 or 1. Errors: kInput with the line
[[nodiscard]] Result<std::vector<TruthPoint>> parse_truth_points(std::string_view text);

}  // namespace cloister
