#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_interface/ros2/message_counters.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "mapping/core/pose.hpp"

namespace cloister::ros2 {

/// What /tf_static says about where sensors sit on the body: a forest of frames by name.
///
/// Threads: one at a time. Memory: one entry a frame.
class StaticTransforms {
 public:
  /// Takes in every transform of the message that is sound; a frame that is known is moved. A frame cannot get a
  /// second parent, nor become its own ancestor: such a transform is counted and dropped.
  void add(const TFMessage& message, MessageCounters& counters);

  /// T_parent_child along any chain of known frames, upwards and downwards; identity for one frame.
  /// @return nothing when no chain joins the two
  [[nodiscard]] std::optional<Pose> find(std::string_view parent, std::string_view child) const;

  [[nodiscard]] std::size_t num_frames() const { return links_.size(); }

 private:
  struct Link {
    std::string parent;
    Pose T_parent_child = Pose::Identity();
  };
  /// A frame above another one, seen from there.
  struct Ancestor {
    std::string_view name;
    Pose T_ancestor_frame = Pose::Identity();
  };
  /// The frame itself, its parent, and so on.
  [[nodiscard]] std::vector<Ancestor> ancestors(std::string_view frame) const;

  std::map<std::string, Link, std::less<>> links_;  ///< by the child's name
};

}  // namespace cloister::ros2
