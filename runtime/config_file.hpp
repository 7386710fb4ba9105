#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

/// The configuration from its three sources, later ones winning: defaults, a TOML file (tables as in
/// `[voxel] voxel_size_m = 0.065`), and `key=value` settings from the command line. Validated once, here.
/// @return kUsage naming the file and line, or the setting, and field, value and bound
[[nodiscard]] Result<ProgramConfig> load_config(const std::optional<std::filesystem::path>& file,
                                                const std::vector<std::string>& settings);

/// The whole configuration as a commented TOML text that `load_config` reads back.
[[nodiscard]] std::string to_toml(const ProgramConfig& config);

}  // namespace cloister
