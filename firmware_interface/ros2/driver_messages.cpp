#include "firmware_interface/ros2/driver_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "firmware_interface/ros2/cloud_layout.hpp"
#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {
namespace {

constexpr std::uint32_t kPointBytes = 48;
constexpr std::size_t kOffsetOfT = 20;
constexpr std::size_t kOffsetOfRing = 26;
constexpr std::size_t kOffsetOfRange = 32;
constexpr std::array<CloudField, 9> kFields = {{{"x", 0, kFloat32},
                                                {"y", 4, kFloat32},
                                                {"z", 8, kFloat32},
                                                {"intensity", 16, kFloat32},
                                                {"t", kOffsetOfT, kUint32},
                                                {"reflectivity", 24, kUint16},
                                                {"ring", kOffsetOfRing, kUint16},
                                                {"ambient", 28, kUint16},
                                                {"range", kOffsetOfRange, kUint32}}};

void set_point(std::uint8_t* point, const Eigen::Vector3f& p_L, std::uint32_t range_mm) {
  std::memcpy(point, p_L.data(), 3 * sizeof(float));
  std::memcpy(point + kOffsetOfRange, &range_mm, sizeof(range_mm));
}

void set_points(PointCloud2& cloud, const Scan& scan) {
  const ScanGeometry& geometry = *scan.geometry;
  SensorTime begin = scan.stamp;
  for (int column = 0; column < geometry.num_columns; ++column) {
    if (scan.column_valid[column]) begin = std::min(begin, scan.column_stamps[column]);
  }
  cloud.header.stamp = time_of(begin);
  std::uint8_t* first =
      make_cloud(cloud, kFields, kPointBytes, static_cast<std::uint32_t>(geometry.num_beams),
                 static_cast<std::uint32_t>(geometry.num_columns));
  for (int beam = 0; beam < geometry.num_beams; ++beam) {
    const auto ring = static_cast<std::uint16_t>(beam);
    for (int column = 0; column < geometry.num_columns; ++column) {
      const int image_column =
          ((column + geometry.pixel_shift[beam]) % geometry.num_columns + geometry.num_columns) %
          geometry.num_columns;
      const std::size_t row_begin = static_cast<std::size_t>(beam) * geometry.num_columns;
      std::uint8_t* point = first + kPointBytes * (row_begin + image_column);
      std::memcpy(point + kOffsetOfRing, &ring, sizeof(ring));
      if (!scan.column_valid[column]) continue;
      const auto t = static_cast<std::uint32_t>((scan.column_stamps[column] - begin).ns);
      std::memcpy(point + kOffsetOfT, &t, sizeof(t));
      const std::size_t pixel = row_begin + column;
      const std::uint32_t range_mm = scan.ranges_mm[pixel];
      if (range_mm == 0) continue;
      const float range_m = 1e-3f * static_cast<float>(range_mm);
      set_point(point, geometry.origin_L[pixel] + range_m * geometry.direction_L[pixel], range_mm);
    }
  }
}

}  // namespace

Message<PointCloud2> scan_message(const Scan& scan, std::string_view frame_id) {
  Message<PointCloud2> message;
  set_header(message->header, scan.stamp, frame_id);
  if (scan.kind == Scan::Kind::kOrganised) {
    set_points(*message, scan);
    return message;
  }
  std::uint8_t* point = make_cloud(*message, kFields, kPointBytes, 1,
                                   static_cast<std::uint32_t>(scan.points_L.size()));
  message->is_dense = true;
  for (const Eigen::Vector3f& p_L : scan.points_L) {
    set_point(point, p_L, static_cast<std::uint32_t>(std::lround(1000.0f * p_L.norm())));
    point += kPointBytes;
  }
  return message;
}

Message<Odometry> odometry_message(const StampedPose& pose, std::string_view odometry_frame,
                                   std::string_view body_frame) {
  Message<Odometry> message;
  set_header(message->header, pose.stamp, odometry_frame);
  set_text(message->child_frame_id, body_frame);
  message->pose.pose = ros_pose(pose.T_O_B);
  return message;
}

Message<Path> path_message(const PoseGraph& graph, std::string_view map_frame) {
  std::vector<const GraphNode*> nodes;
  for (const GraphNode& node : graph.nodes) nodes.push_back(&node);
  std::ranges::stable_sort(nodes, {}, [](const GraphNode* node) { return node->stamp; });
  Message<Path> message;
  set_header(message->header, graph.stamp, map_frame);
  auto* pose = make_elements(message->poses, nodes.size());
  for (const GraphNode* node : nodes) {
    set_header(pose->header, node->stamp, map_frame);
    pose->pose = ros_pose(node->T_M_N);
    ++pose;
  }
  return message;
}

}  // namespace cloister::ros2
