#pragma once

#include <string_view>

#include "firmware_interface/files/stamped_pose.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/map_messages.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/scan/scan.hpp"

/// What drivers and a SLAM system publish, made from a recorded mission. Pure functions; all allocate.
namespace cloister::ros2 {

/// A scan as ouster-ros publishes it: x, y, z, intensity, t, reflectivity, ring (UINT16), ambient and range in 48 bytes
/// a point. An organised scan is destaggered by `pixel_shift`, misses are zero, and the header's stamp is that of the
/// first valid column, from which `t` counts. A cloud has one row and the scan's own stamp, with `t` and `ring` zero.
[[nodiscard]] Message<PointCloud2> scan_message(const Scan& scan, std::string_view frame_id);

[[nodiscard]] Message<Odometry> odometry_message(const StampedPose& pose,
                                                 std::string_view odometry_frame,
                                                 std::string_view body_frame);

/// A graph's poses in the order of their stamps; its edges do not travel.
[[nodiscard]] Message<Path> path_message(const PoseGraph& graph, std::string_view map_frame);

}  // namespace cloister::ros2
