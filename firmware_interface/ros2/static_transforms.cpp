#include "firmware_interface/ros2/static_transforms.hpp"

#include <algorithm>

#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {

void StaticTransforms::add(const TFMessage& message, MessageCounters& counters) {
  for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
    const auto& stamped = message.transforms._buffer[i];
    const std::string_view parent = frame_name(stamped.header.frame_id);
    const std::string_view child = frame_name(stamped.child_frame_id);
    const auto T_parent_child = pose_of(stamped.transform);
    if (!T_parent_child) {
      counters.add(MessageCause::kBadPose);
      continue;
    }
    const auto known = links_.find(child);
    const std::vector<Ancestor> above = ancestors(parent);
    if ((known != links_.end() && known->second.parent != parent) ||
        std::ranges::find(above, child, &Ancestor::name) != above.end()) {
      counters.add(MessageCause::kConflictingTransform);
      continue;
    }
    links_.insert_or_assign(std::string(child), Link{std::string(parent), *T_parent_child});
  }
}

std::vector<StaticTransforms::Ancestor> StaticTransforms::ancestors(std::string_view frame) const {
  std::vector<Ancestor> found = {{frame}};
  for (auto it = links_.find(frame); it != links_.end(); it = links_.find(it->second.parent)) {
    found.push_back({it->second.parent, it->second.T_parent_child * found.back().T_ancestor_frame});
  }
  return found;
}

std::optional<Pose> StaticTransforms::find(std::string_view parent, std::string_view child) const {
  const std::vector<Ancestor> above_parent = ancestors(parent);
  for (const Ancestor& ancestor : ancestors(child)) {
    const auto common = std::ranges::find(above_parent, ancestor.name, &Ancestor::name);
    if (common != above_parent.end()) {
      return common->T_ancestor_frame.inverse() * ancestor.T_ancestor_frame;
    }
  }
  return std::nullopt;
}

}  // namespace cloister::ros2
