#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "firmware_interface/files/stamped_pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// What the order of a trajectory's lines means.
enum class TumOrder {
  /// Lines follow time. One that goes back is refused. Of lines with one stamp the last counts: a
  /// restarted odometry repeats its last stamp with its new pose.
  kAscending,
  /// Every line is kept as it stands, whatever its stamp.
  kAsWritten,
};

/// Reads a trajectory in TUM text: `t x y z qx qy qz qw`, t in decimal seconds, read exactly to the
/// nanosecond. A text without lines gives an empty trajectory.
/// @param file_name for messages
/// @return poses, or kInput with file:line at the first malformed line
[[nodiscard]] Result<std::vector<StampedPose>> read_tum(std::string_view text,
                                                        std::string_view file_name,
                                                        TumOrder order = TumOrder::kAscending);

/// The same from a file.
[[nodiscard]] Result<std::vector<StampedPose>> load_tum(const std::filesystem::path& path,
                                                        TumOrder order = TumOrder::kAscending);

/// Gives the nodes of a graph without stamps their stamps from its sidecar `nodes.tum`: line k
/// belongs to the k-th node by ascending id. The sidecar may hold more lines, since a snapshot may
/// hold only the first nodes of a mission. Nodes that have a stamp keep it. Poses of the sidecar
/// are not looked at: those of the graph are newer.
/// @param lines in the order written (TumOrder::kAsWritten)
/// @return kInput when there are fewer lines than nodes; the graph is unchanged then
[[nodiscard]] Result<void> set_node_stamps(PoseGraph& graph, std::span<const StampedPose> lines,
                                           std::string_view file_name);

}  // namespace cloister
