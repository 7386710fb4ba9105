#pragma once

#include <optional>

#include "firmware_interface/dds/dds_options.hpp"
#include "firmware_interface/ros2/driver_topics.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

/// What the texts of a live mission's settings mean.
struct LiveSettings {
  DdsOptions dds;
  enum class Source { kDds, kSensor, kRos2 };
  Source source = Source::kDds;  ///< of scans; with kRos2 of odometry and graphs as well
  ros2::DriverTopicNames ros2_topics;
  std::optional<Pose> T_pose_sensor;
};

/// @return kUsage, naming the setting, when one of them means nothing
[[nodiscard]] Result<LiveSettings> live_settings(const ProgramConfig& config);

}  // namespace cloister
