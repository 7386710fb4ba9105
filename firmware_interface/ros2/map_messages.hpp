#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "firmware_interface/map/map_contents.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"
#include "mapping/submap/submap.hpp"

/// What the map tells ROS 2: pure functions from the project's types to messages. All allocate; none keeps anything.
namespace cloister::ros2 {

/// When a message speaks of, and the frame that its coordinates are in.
struct MessageHeader {
  SensorTime stamp;
  std::string_view frame_id;
};

/// A submap as a viewer shows it.
struct SubmapMarker {
  SubmapId id = kNoSubmap;
  Pose T_M_S = Pose::Identity();
  Eigen::AlignedBox3d bounds_S;  ///< of what it knows; an empty one is not drawn
  Eigen::Vector3d root_M = Eigen::Vector3d::Zero();  ///< its root node
  bool is_active = false;                            ///< drawn more solid
};

/// A loop closure, from node to node.
struct LoopMarker {
  Eigen::Vector3d from_M = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_M = Eigen::Vector3d::Zero();
};

/// Boxes (`submaps`), their ids as text (`ids`), spheres at their roots (`roots`) and one list of lines (`loops`).
/// The first marker deletes all others, so that what was fused since the last message goes.
[[nodiscard]] Message<MarkerArray> markers_message(const MessageHeader& header,
                                                   std::span<const SubmapMarker> submaps,
                                                   std::span<const LoopMarker> loops);

/// The centres of the view's occupied voxels in M, submap by submap: x, y, z, rgb (the colour of the submap, as PCL
/// packs it into a float) and submap (its id, INT32). 20 bytes a point.
[[nodiscard]] Message<PointCloud2> occupied_cloud_message(const MessageHeader& header,
                                                          const MapView& map);

/// One transform: `T_parent_child` at the header's stamp; the header's frame is the parent.
[[nodiscard]] Message<TFMessage> transform_message(const MessageHeader& header,
                                                   std::string_view child_frame_id,
                                                   const Pose& T_parent_child);

/// The view's submaps combined, as octomap_msgs has it: occupied or free (`binary`), or with log-odds.
/// @return kResource when the submaps reach farther from M's origin than OctoMap can hold
[[nodiscard]] Result<Message<OctomapMessage>> octomap_message(const MessageHeader& header,
                                                              const MapView& map,
                                                              bool with_log_odds);

/// diagnostic_msgs/DiagnosticStatus.
struct Diagnostic {
  enum class Level : std::uint8_t { kOk = 0, kWarning = 1, kError = 2, kStale = 3 };
  Level level = Level::kOk;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<std::pair<std::string, std::string>> values;
};

[[nodiscard]] Message<DiagnosticArray> diagnostics_message(SensorTime stamp,
                                                           std::span<const Diagnostic> statuses);

}  // namespace cloister::ros2
