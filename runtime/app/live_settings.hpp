#pragma once

#include <optional>

#include "firmware_interface/dds/dds_options.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

/// What the texts of a live mission's settings mean.
struct LiveSettings {
  DdsOptions dds;
  bool from_sensor = false;  ///< scans come straight from the sensor
  std::optional<Pose> T_pose_sensor;
};

/// @return kUsage, naming the setting, when one of them means nothing
[[nodiscard]] Result<LiveSettings> live_settings(const ProgramConfig& config);

}  // namespace cloister
