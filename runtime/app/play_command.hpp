#pragma once

#include <filesystem>
#include <string>

#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

struct PlayOptions {
  std::filesystem::path mission;
  double rate = 1.0;     ///< times the mission's own pace
  double start_s = 0.0;  ///< of the mission, where to begin
  bool raw_packets =
      false;  ///< scans as the sensor's packets, to `host` and `port`, in place of DDS
  bool as_ros2 =
      false;  ///< with the topics and messages of ROS 2's drivers in place of Cloister's own
  std::string host = "127.0.0.1";
  int port = 7502;
};

/// Publishes a recorded mission as the robot would, at its own pace. Waits up to ten seconds for somebody who reads it,
/// and then begins in any case.
/// @return kInterrupted after a signal
[[nodiscard]] Result<void> run_play(const PlayOptions& options, const ProgramConfig& config);

}  // namespace cloister
