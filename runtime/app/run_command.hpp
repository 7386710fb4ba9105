#pragma once

#include <filesystem>

#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

struct RunOptions {
  std::filesystem::path out;
  bool show_progress = false;  ///< on stderr
};

/// Maps a live mission until SIGTERM or SIGINT, and then leaves the same in `out` as a replay. Scans come over DDS or
/// straight from the sensor, odometry and graphs over DDS.
/// @return kInterrupted after SIGINT, nothing wrong after SIGTERM; kResource when DDS, the port, the sensor or the
///         directory cannot be had
[[nodiscard]] Result<void> run_live(const RunOptions& options, const ProgramConfig& config);

}  // namespace cloister
