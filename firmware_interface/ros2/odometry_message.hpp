#pragma once

#include <optional>
#include <string>

#include "firmware_interface/files/stamped_pose.hpp"
#include "firmware_interface/ros2/message_counters.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"

namespace cloister::ros2 {

/// Turns the messages of one odometry topic into poses. The frames of the first message are those of the topic: what
/// comes with others is counted and dropped, since it is the pose of something else.
class OdometryDecoder {
 public:
  /// @return nothing, counted, when stamp, pose or frames are not as they should be
  [[nodiscard]] std::optional<StampedPose> pose(const Odometry& message, MessageCounters& counters);

  /// Names of O and B (`header.frame_id`, `child_frame_id`); empty before the first message.
  [[nodiscard]] const std::string& odometry_frame() const { return odometry_frame_; }
  [[nodiscard]] const std::string& body_frame() const { return body_frame_; }

 private:
  bool has_begun_ = false;
  std::string odometry_frame_;
  std::string body_frame_;
};

}  // namespace cloister::ros2
