#pragma once

#include <filesystem>

#include "mapping/core/result.hpp"

namespace cloister {

/// `cloister query`: the state of each point of a CSV file, as CSV on stdout.
[[nodiscard]] Result<void> run_query(const std::filesystem::path& map, const std::filesystem::path& points);

/// `cloister export`: the map in another format, by the suffix of `out`.
[[nodiscard]] Result<void> run_export(const std::filesystem::path& map, const std::filesystem::path& out, bool cloud);

/// `cloister uncertainty`: relative covariances of node pairs, as CSV on stdout.
/// @param gtsam_default  residual Jacobians as GTSAM's default has them, instead of exact ones
[[nodiscard]] Result<void> run_uncertainty(const std::filesystem::path& graph, const std::filesystem::path& pairs,
                                           double default_information, bool gtsam_default);

}  // namespace cloister
