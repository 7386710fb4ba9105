#pragma once

#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

/// Watches DDS for some seconds and prints what is there: a line a topic with its type, rate and size. Rates are
/// measured for Cloister's own topics; of others, only that they exist.
[[nodiscard]] Result<void> run_topics(double seconds, const ProgramConfig& config);

}  // namespace cloister
