#pragma once

#include <nlohmann/json.hpp>

#include "mapping/core/config.hpp"

namespace cloister {

/// The whole configuration as nested JSON, keys named and ordered as in the config file.
[[nodiscard]] nlohmann::ordered_json config_json(const Config& config);

}  // namespace cloister
