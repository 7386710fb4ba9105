#pragma once

#include <nlohmann/json.hpp>

#include "mapping/core/config.hpp"

namespace cloister {

/// The whole configuration as nested JSON, keys named as in the config file and in their order
/// there.
[[nodiscard]] nlohmann::ordered_json config_json(const Config& config);

}  // namespace cloister
