#include "firmware_interface/ros2/map_messages.hpp"

#include <array>
#include <cstring>

#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/occupied_points.hpp"
#include "firmware_interface/output/submap_colour.hpp"
#include "firmware_interface/ros2/cloud_layout.hpp"
#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {
namespace {

// visualization_msgs/Marker
constexpr std::int32_t kCube = 1;
constexpr std::int32_t kSphere = 2;
constexpr std::int32_t kLineList = 5;
constexpr std::int32_t kTextFacingViewer = 9;
constexpr std::int32_t kAdd = 0;
constexpr std::int32_t kDeleteAll = 3;

constexpr float kBoxAlpha = 0.15f;
constexpr float kActiveBoxAlpha = 0.35f;
constexpr double kRootDiameter_m = 0.4;
constexpr double kTextHeight_m = 0.8;
constexpr double kLineWidth_m = 0.05;
constexpr Color kLoopColour{0.9f, 0.1f, 0.1f, 0.9f};

Color colour_of(SubmapId id, float alpha) {
  const Rgb rgb = submap_colour(id);
  return {static_cast<float>(rgb.r) / 255.0f, static_cast<float>(rgb.g) / 255.0f,
          static_cast<float>(rgb.b) / 255.0f, alpha};
}

/// A marker without size; viewers want a valid rotation for each.
void set_marker(Marker& marker, const MessageHeader& header, std::string_view name, std::int32_t id,
                std::int32_t type) {
  set_header(marker.header, header.stamp, header.frame_id);
  set_text(marker.ns, name);
  marker.id = id;
  marker.type = type;
  marker.action = kAdd;
  marker.pose = ros_pose(Pose::Identity());
}

Pose at(const Eigen::Vector3d& p_M) { return Pose(Eigen::Translation3d(p_M)); }

void set_submap_markers(Marker* marker, const MessageHeader& header, const SubmapMarker& submap) {
  Pose T_M_box = submap.T_M_S;
  T_M_box.translation() = submap.T_M_S * submap.bounds_S.center();
  const Eigen::Vector3d size = submap.bounds_S.sizes();
  set_marker(marker[0], header, "submaps", submap.id, kCube);
  marker[0].pose = ros_pose(T_M_box);
  marker[0].scale = {size.x(), size.y(), size.z()};
  marker[0].color = colour_of(submap.id, submap.is_active ? kActiveBoxAlpha : kBoxAlpha);

  set_marker(marker[1], header, "ids", submap.id, kTextFacingViewer);
  marker[1].pose = ros_pose(at(T_M_box.translation() + Eigen::Vector3d(0, 0, 0.5 * size.z())));
  marker[1].scale = {0, 0, kTextHeight_m};
  marker[1].color = colour_of(submap.id, 1);
  set_text(marker[1].text, std::to_string(submap.id));

  set_marker(marker[2], header, "roots", submap.id, kSphere);
  marker[2].pose = ros_pose(at(submap.root_M));
  marker[2].scale = {kRootDiameter_m, kRootDiameter_m, kRootDiameter_m};
  marker[2].color = colour_of(submap.id, 1);
}

}  // namespace

Message<MarkerArray> markers_message(const MessageHeader& header,
                                     std::span<const SubmapMarker> submaps,
                                     std::span<const LoopMarker> loops) {
  constexpr std::size_t kMarkersEach = 3;
  std::size_t num_drawn = 0;
  for (const SubmapMarker& submap : submaps) num_drawn += !submap.bounds_S.isEmpty();
  Message<MarkerArray> message;
  Marker* marker = make_elements(message->markers, 1 + kMarkersEach * num_drawn + !loops.empty());
  set_marker(*marker, header, "", 0, kCube);
  marker->action = kDeleteAll;
  ++marker;
  for (const SubmapMarker& submap : submaps) {
    if (submap.bounds_S.isEmpty()) continue;
    set_submap_markers(marker, header, submap);
    marker += kMarkersEach;
  }
  if (loops.empty()) return message;
  set_marker(*marker, header, "loops", 0, kLineList);
  marker->scale.x = kLineWidth_m;
  marker->color = kLoopColour;
  auto* end = make_elements(marker->points, 2 * loops.size());
  for (const LoopMarker& loop : loops) {
    *end++ = {loop.from_M.x(), loop.from_M.y(), loop.from_M.z()};
    *end++ = {loop.to_M.x(), loop.to_M.y(), loop.to_M.z()};
  }
  return message;
}

Message<PointCloud2> occupied_cloud_message(const MessageHeader& header, const MapView& map) {
  constexpr std::array<CloudField, 5> kFields = {{{"x", 0, kFloat32},
                                                  {"y", 4, kFloat32},
                                                  {"z", 8, kFloat32},
                                                  {"rgb", 12, kFloat32},
                                                  {"submap", 16, kInt32}}};
  constexpr std::uint32_t kPointBytes = 20;
  Message<PointCloud2> message;
  set_header(message->header, header.stamp, header.frame_id);
  std::uint8_t* byte = make_cloud(*message, kFields, kPointBytes, 1,
                                  static_cast<std::uint32_t>(count_occupied(map)));
  message->is_dense = true;
  for_each_occupied_point(map, [&](const Submap& submap, const Eigen::Vector3d& p_M) {
    const Eigen::Vector3f p = p_M.cast<float>();
    const Rgb rgb = submap_colour(submap.id);
    const std::uint32_t packed = std::uint32_t{rgb.r} << 16 | std::uint32_t{rgb.g} << 8 | rgb.b;
    std::memcpy(byte, p.data(), 12);
    std::memcpy(byte + 12, &packed, 4);
    std::memcpy(byte + 16, &submap.id, 4);
    byte += kPointBytes;
  });
  return message;
}

Message<TFMessage> transform_message(const MessageHeader& header, std::string_view child_frame_id,
                                     const Pose& T_parent_child) {
  Message<TFMessage> message;
  auto* stamped = make_elements(message->transforms, 1);
  set_header(stamped->header, header.stamp, header.frame_id);
  set_text(stamped->child_frame_id, child_frame_id);
  stamped->transform = ros_transform(T_parent_child);
  return message;
}

Result<Message<OctomapMessage>> octomap_message(const MessageHeader& header, const MapView& map,
                                                bool with_log_odds) {
  const Result<std::string> data = octomap_data(map, with_log_odds);
  if (!data) return tl::unexpected(data.error());
  return octomap_message(header, map.info.voxel_size_m, *data, with_log_odds);
}

Message<OctomapMessage> octomap_message(const MessageHeader& header, double voxel_size_m,
                                        std::string_view data, bool with_log_odds) {
  Message<OctomapMessage> message;
  set_header(message->header, header.stamp, header.frame_id);
  message->binary = !with_log_odds;
  set_text(message->id, "OcTree");
  message->resolution = voxel_size_m;
  std::memcpy(make_elements(message->data, data.size()), data.data(), data.size());
  return message;
}

Message<DiagnosticArray> diagnostics_message(SensorTime stamp,
                                             std::span<const Diagnostic> statuses) {
  Message<DiagnosticArray> message;
  set_header(message->header, stamp, "");
  DiagnosticStatus* status = make_elements(message->status, statuses.size());
  for (const Diagnostic& diagnostic : statuses) {
    status->level = static_cast<std::uint8_t>(diagnostic.level);
    set_text(status->name, diagnostic.name);
    set_text(status->message, diagnostic.message);
    set_text(status->hardware_id, diagnostic.hardware_id);
    auto* value = make_elements(status->values, diagnostic.values.size());
    for (const auto& [key, text] : diagnostic.values) {
      set_text(value->key, key);
      set_text(value->value, text);
      ++value;
    }
    ++status;
  }
  return message;
}

}  // namespace cloister::ros2
