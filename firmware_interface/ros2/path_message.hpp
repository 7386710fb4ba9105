#pragma once

#include <map>
#include <optional>
#include <string>

#include "firmware_interface/ros2/message_counters.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister::ros2 {

/// Turns a trajectory that a SLAM system publishes anew after each optimisation into revisions of a pose graph.
///
/// A pose's stamp says which node it is: poses move from message to message, stamps do not. Nodes are numbered from 0
/// in the order they are first seen, so that one which is left out for a while comes back as itself. A path has no
/// measurements between its poses: the graph has no edges, hence no loop closures and no uncertainty
/// (see FusionConfig::fuse_without_covariance).
///
/// Threads: one at a time. Memory: one entry a node ever seen.
class PathDecoder {
 public:
  /// @return the graph as it stands now, its stamp the message's or, if that is zero, its newest pose's; nothing,
  ///         counted, when the path is empty, a stamp or pose is bad, two poses have one stamp, or the frame is not
  ///         the one of the first path
  [[nodiscard]] std::optional<PoseGraph> graph(const Path& message, MessageCounters& counters);

  /// Name of M; empty before the first path.
  [[nodiscard]] const std::string& map_frame() const { return map_frame_; }

 private:
  [[nodiscard]] std::optional<PoseGraph> poses_of(const Path& message, MessageCounters& counters);

  bool has_begun_ = false;
  std::string map_frame_;
  std::map<SensorTime, NodeId> ids_;
};

/// What to say of a trajectory's topic when it is used.
[[nodiscard]] std::string warning_without_covariances(const std::string& topic);

}  // namespace cloister::ros2
