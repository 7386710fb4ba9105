#include "firmware_interface/ros2/message_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloister::ros2 {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr double kUnitTolerance = 0.01;

template <typename Vector, typename Quaternion>
std::optional<Pose> checked_pose(const Vector& t, const Quaternion& q) {
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  // Negated, so that it is true for what is not a number.
  if (!(std::abs(rotation.norm() - 1.0) <= kUnitTolerance)) return std::nullopt;
  const Pose pose = make_pose({t.x, t.y, t.z}, rotation);
  if (!is_finite(pose)) return std::nullopt;
  return pose;
}

}  // namespace

std::optional<SensorTime> stamp_of(const Time& time) {
  if (time.nanosec >= kSecondNs) return std::nullopt;
  return SensorTime{time.sec * kSecondNs + time.nanosec};
}

Time time_of(SensorTime stamp) {
  std::int64_t seconds = stamp.ns / kSecondNs;
  if (stamp.ns % kSecondNs < 0) --seconds;
  const std::int64_t rest = stamp.ns - seconds * kSecondNs;
  using Limits = std::numeric_limits<std::int32_t>;
  seconds = std::clamp(seconds, std::int64_t{Limits::min()}, std::int64_t{Limits::max()});
  return {static_cast<std::int32_t>(seconds), static_cast<std::uint32_t>(rest)};
}

std::optional<Pose> pose_of(const RosPose& pose) {
  return checked_pose(pose.position, pose.orientation);
}

std::optional<Pose> pose_of(const Transform& transform) {
  return checked_pose(transform.translation, transform.rotation);
}

RosPose ros_pose(const Pose& T_A_B) {
  const Eigen::Vector3d t = T_A_B.translation();
  const Eigen::Quaterniond q(T_A_B.linear());
  return {{t.x(), t.y(), t.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

Transform ros_transform(const Pose& T_A_B) {
  const Eigen::Vector3d t = T_A_B.translation();
  const Eigen::Quaterniond q(T_A_B.linear());
  return {{t.x(), t.y(), t.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

std::string_view frame_name(const char* frame_id) {
  std::string_view name = frame_id != nullptr ? frame_id : "";
  if (name.starts_with('/')) name.remove_prefix(1);
  return name;
}

void set_text(char*& text, std::string_view value) {
  dds_free(text);
  text = static_cast<char*>(dds_alloc(value.size() + 1));
  value.copy(text, value.size());
  text[value.size()] = '\0';
}

void set_header(Header& header, SensorTime stamp, std::string_view frame_id) {
  header.stamp = time_of(stamp);
  set_text(header.frame_id, frame_id);
}

}  // namespace cloister::ros2
