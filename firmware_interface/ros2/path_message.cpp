#include "firmware_interface/ros2/path_message.hpp"

#include <algorithm>

#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {

std::optional<PoseGraph> PathDecoder::poses_of(const Path& message, MessageCounters& counters) {
  const auto drop = [&counters](MessageCause cause) {
    counters.add(cause);
    return std::nullopt;
  };
  const auto stamp = stamp_of(message.header.stamp);
  if (!stamp) return drop(MessageCause::kBadStamp);
  if (message.poses._length == 0) return drop(MessageCause::kEmptyPath);
  if (has_begun_ && map_frame_ != frame_name(message.header.frame_id)) {
    return drop(MessageCause::kChangedFrame);
  }
  PoseGraph graph;
  graph.nodes.reserve(message.poses._length);
  for (std::uint32_t i = 0; i < message.poses._length; ++i) {
    GraphNode& node = graph.nodes.emplace_back();
    const auto node_stamp = stamp_of(message.poses._buffer[i].header.stamp);
    const auto T_M_N = pose_of(message.poses._buffer[i].pose);
    if (!node_stamp) return drop(MessageCause::kBadStamp);
    if (!T_M_N) return drop(MessageCause::kBadPose);
    node.stamp = *node_stamp;
    node.has_stamp = true;
    node.T_M_N = *T_M_N;
  }
  std::ranges::sort(graph.nodes, {}, &GraphNode::stamp);
  if (std::ranges::adjacent_find(graph.nodes, {}, &GraphNode::stamp) != graph.nodes.end()) {
    return drop(MessageCause::kAmbiguousPath);
  }
  graph.stamp = stamp->ns != 0 ? *stamp : graph.nodes.back().stamp;
  return graph;
}

std::string warning_without_covariances(const std::string& topic) {
  return topic +
         " has no covariances: the uncertainty check is unavailable, and "
         "fusion.fuse_without_covariance decides in its place";
}

std::optional<PoseGraph> PathDecoder::graph(const Path& message, MessageCounters& counters) {
  std::optional<PoseGraph> graph = poses_of(message, counters);
  if (!graph) return graph;
  if (!has_begun_) {
    has_begun_ = true;
    map_frame_ = frame_name(message.header.frame_id);
  }
  for (GraphNode& node : graph->nodes) {
    node.id = ids_.try_emplace(node.stamp, static_cast<NodeId>(ids_.size())).first->second;
  }
  std::ranges::sort(graph->nodes, {}, &GraphNode::id);
  return graph;
}

}  // namespace cloister::ros2
