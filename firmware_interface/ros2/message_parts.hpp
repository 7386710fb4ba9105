#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include <dds/dds.h>

#include "firmware_interface/ros2/ros2_types.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"

/// The parts that messages share, and memory as Cyclone DDS frees it.
namespace cloister::ros2 {

/// @return nothing when the nanoseconds are a second or more
[[nodiscard]] std::optional<SensorTime> stamp_of(const Time& time);
/// Seconds that do not fit into 32 bits become the nearest that do.
[[nodiscard]] Time time_of(SensorTime stamp);

/// A pose, its quaternion normalised.
/// @return nothing when a number is not finite, or the quaternion is more than 1 % off unit length
[[nodiscard]] std::optional<Pose> pose_of(const RosPose& pose);
[[nodiscard]] std::optional<Pose> pose_of(const Transform& transform);
[[nodiscard]] RosPose ros_pose(const Pose& T_A_B);
[[nodiscard]] Transform ros_transform(const Pose& T_A_B);

/// A frame's name as tf2 knows it: without the slash that ROS 1 put in front. Empty for a null pointer.
[[nodiscard]] std::string_view frame_name(const char* frame_id);

/// Replaces a message's string.
void set_text(char*& text, std::string_view value);
void set_header(Header& header, SensorTime stamp, std::string_view frame_id);

/// Gives an empty sequence of a message so many elements, all zero.
template <typename Sequence>
auto* make_elements(Sequence& sequence, std::size_t count) {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  sequence._buffer = static_cast<Element*>(dds_alloc(count * sizeof(Element)));
  std::fill_n(sequence._buffer, count, Element{});
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(count);
  sequence._release = true;
  return sequence._buffer;
}

}  // namespace cloister::ros2
