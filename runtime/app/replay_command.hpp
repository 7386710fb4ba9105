#pragma once

#include <filesystem>

#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

struct ReplayOptions {
  std::filesystem::path mission;
  std::filesystem::path out;
  bool realtime = false;       ///< paced by the stamps, late scans dropped; else lockstep
  bool show_progress = false;  ///< on stderr
};

/// Replays a mission and leaves its map and reports in `out`. Lockstep: as fast as it can, no scan dropped, the same
/// map for every run and every number of workers. SIGINT and SIGTERM end the mission early with all outputs written.
/// @return kInterrupted after a signal. An input that turns out malformed on the way is kInput; what was mapped until
///         then is written first.
[[nodiscard]] Result<void> run_replay(const ReplayOptions& options, const ProgramConfig& config);

}  // namespace cloister
