#pragma once

#include <span>
#include <string_view>

#include "firmware_interface/map/map_contents.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/map_parts.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"

/// What the map tells ROS 2: pure functions from the project's types to messages. All allocate; none keeps anything.
namespace cloister::ros2 {

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

/// The same from what octomap_data has written.
[[nodiscard]] Message<OctomapMessage> octomap_message(const MessageHeader& header,
                                                      double voxel_size_m, std::string_view data,
                                                      bool with_log_odds);

[[nodiscard]] Message<DiagnosticArray> diagnostics_message(SensorTime stamp,
                                                           std::span<const Diagnostic> statuses);

}  // namespace cloister::ros2
