#pragma once

#include <ros2_messages.h>

/// Short names for what the IDL compiler makes of ros2_messages.idl.
namespace cloister::ros2 {

using Color = std_msgs_msg_dds__ColorRGBA_;
using DiagnosticArray = diagnostic_msgs_msg_dds__DiagnosticArray_;
using DiagnosticStatus = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using Empty = std_msgs_msg_dds__Empty_;
using Header = std_msgs_msg_dds__Header_;
using Marker = visualization_msgs_msg_dds__Marker_;
using MarkerArray = visualization_msgs_msg_dds__MarkerArray_;
using OctomapMessage = octomap_msgs_msg_dds__Octomap_;
using Odometry = nav_msgs_msg_dds__Odometry_;
using Path = nav_msgs_msg_dds__Path_;
using PointCloud2 = sensor_msgs_msg_dds__PointCloud2_;
using PointField = sensor_msgs_msg_dds__PointField_;
using RosPose = geometry_msgs_msg_dds__Pose_;
using TFMessage = tf2_msgs_msg_dds__TFMessage_;
using Time = builtin_interfaces_msg_dds__Time_;
using Transform = geometry_msgs_msg_dds__Transform_;

/// What Cyclone DDS needs to know about a topic's type.
template <typename Topic>
[[nodiscard]] const dds_topic_descriptor_t& descriptor();

template <>
inline const dds_topic_descriptor_t& descriptor<DiagnosticArray>() {
  return diagnostic_msgs_msg_dds__DiagnosticArray__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Empty>() {
  return std_msgs_msg_dds__Empty__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<MarkerArray>() {
  return visualization_msgs_msg_dds__MarkerArray__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<OctomapMessage>() {
  return octomap_msgs_msg_dds__Octomap__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Odometry>() {
  return nav_msgs_msg_dds__Odometry__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Path>() {
  return nav_msgs_msg_dds__Path__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<PointCloud2>() {
  return sensor_msgs_msg_dds__PointCloud2__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<TFMessage>() {
  return tf2_msgs_msg_dds__TFMessage__desc;
}

}  // namespace cloister::ros2
