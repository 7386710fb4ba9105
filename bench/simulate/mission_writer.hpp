#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "bench/simulate/cloud_writer.hpp"
#include "bench/simulate/odometry.hpp"
#include "bench/simulate/sensor_model.hpp"
#include "bench/simulate/slam_standin.hpp"
#include "bench/simulate/trajectory.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// Everything a mission is made of but the world and the way through it.
struct MissionOptions {
  std::filesystem::path out;
  std::uint64_t seed = 1;
  double max_minutes = 0.0;  ///< the mission ends there; 0 = at the end of the path
  int threads = 1;
  SensorModel sensor;
  DriftConfig drift;
  SlamConfig slam;
  std::optional<CloudKind> clouds;  ///< in place of packets, metadata and odometry
};

/// What was written.
struct MissionSummary {
  std::uint64_t scans = 0;
  double seconds = 0.0;
  double metres = 0.0;
  std::size_t nodes = 0;
  int loop_closures = 0;
  std::uint64_t bytes = 0;
  bool interrupted = false;  ///< the mission was cut short, and is complete up to there
};

/// Called after every batch of scans with scans done and scans in all.
using Progress = std::function<void(std::uint64_t, std::uint64_t)>;

/// When a simulated mission begins: a Unix time, so that stamps need all their digits.
inline constexpr SensorTime kMissionStart{1'700'000'000'250'000'000};

/// Simulates a mission and writes its directory: in a hidden one beside it first, which takes its
/// name when it is complete. An older mission of that name is replaced; any other directory that
/// holds something is left alone. The bytes depend on the world, the path and the options, not on
/// the number of threads.
/// @param truth T_W_L, beginning at kMissionStart; the first scan begins 0.2 s later
/// @param interrupted set from outside to end the mission early
/// Errors: kUsage when `out` is in the way, kResource when the disk refuses, kInput for a world
/// without triangles
[[nodiscard]] Result<MissionSummary> write_mission(const World& world, Trajectory truth,
                                                   const MissionOptions& options,
                                                   const std::atomic<bool>& interrupted,
                                                   const Progress& progress);

}  // namespace cloister
