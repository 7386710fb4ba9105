#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "firmware_interface/ros2/ros2_types.hpp"

namespace cloister::ros2 {

// sensor_msgs/PointField
inline constexpr std::uint8_t kUint8 = 2;
inline constexpr std::uint8_t kUint16 = 4;
inline constexpr std::uint8_t kInt32 = 5;
inline constexpr std::uint8_t kUint32 = 6;
inline constexpr std::uint8_t kFloat32 = 7;
inline constexpr std::uint8_t kFloat64 = 8;

/// One value of every point.
struct CloudField {
  std::string_view name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
};

/// Gives an empty cloud its fields and so many points, all zero, in the byte order of this machine.
/// @return the first byte of the first point; points follow each other without gaps
std::uint8_t* make_cloud(PointCloud2& cloud, std::span<const CloudField> fields,
                         std::uint32_t point_bytes, std::uint32_t height, std::uint32_t width);

}  // namespace cloister::ros2
