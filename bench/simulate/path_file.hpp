#pragma once

#include <filesystem>

#include "bench/simulate/trajectory.hpp"
#include "bench/simulate/walk.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// The way through a world read from a file, as T_W_L at 100 Hz from `start` on.
///
/// Eight numbers a line: a TUM trajectory of the sensor, replayed as it is. Three (`x y z`) or four
/// (`x y z pause_s`): places the sensor is walked through. `#` starts a comment. Errors: kInput
/// with file and line
[[nodiscard]] Result<Trajectory> read_path(const std::filesystem::path& path,
                                           const WalkConfig& config, SensorTime start,
                                           std::uint64_t seed);

}  // namespace cloister
