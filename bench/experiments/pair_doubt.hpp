#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "mapping/core/result.hpp"

namespace cloister {

/// Graph nodes that two submaps hang on.
using RootPair = std::pair<std::int64_t, std::int64_t>;

/// The roots of the pairs that cloister-bench-final-map lists. Errors: kInput for an entry without roots
[[nodiscard]] Result<std::vector<RootPair>> read_root_pairs(const nlohmann::json& final_map);

/// Asks `cloister uncertainty` how well the newest graph of a folder knows each pair's place relative to each other:
/// the largest translational standard deviation, metres; 0 for two equal roots, infinite where one has no root.
/// @param scratch  gets pairs.csv and doubts.csv
/// Errors: those of the program; kInput for an answer that cannot be read
[[nodiscard]] Result<std::vector<double>> ask_doubts_m(const std::filesystem::path& cloister,
                                                       const std::filesystem::path& pose_graphs,
                                                       const std::filesystem::path& scratch,
                                                       const std::vector<RootPair>& pairs);

/// The last cell of each row below the header is the largest variance. Errors: kInput with file:line
[[nodiscard]] Result<std::vector<double>> parse_doubts_m(std::string_view csv,
                                                         std::string_view file_name);

}  // namespace cloister
