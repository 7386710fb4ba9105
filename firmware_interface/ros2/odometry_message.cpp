#include "firmware_interface/ros2/odometry_message.hpp"

#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {

std::optional<StampedPose> OdometryDecoder::pose(const Odometry& message,
                                                 MessageCounters& counters) {
  const auto stamp = stamp_of(message.header.stamp);
  if (!stamp) {
    counters.add(MessageCause::kBadStamp);
    return std::nullopt;
  }
  const auto T_O_B = pose_of(message.pose.pose);
  if (!T_O_B) {
    counters.add(MessageCause::kBadPose);
    return std::nullopt;
  }
  const std::string_view odometry_frame = frame_name(message.header.frame_id);
  const std::string_view body_frame = frame_name(message.child_frame_id);
  if (!has_begun_) {
    has_begun_ = true;
    odometry_frame_ = odometry_frame;
    body_frame_ = body_frame;
  } else if (odometry_frame_ != odometry_frame || body_frame_ != body_frame) {
    counters.add(MessageCause::kChangedFrame);
    return std::nullopt;
  }
  return StampedPose{*stamp, *T_O_B};
}

}  // namespace cloister::ros2
