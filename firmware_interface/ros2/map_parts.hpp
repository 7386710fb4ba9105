#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/submap/submap.hpp"

/// What the map tells ROS 2, as plain types.
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

/// diagnostic_msgs/DiagnosticStatus.
struct Diagnostic {
  enum class Level : std::uint8_t { kOk = 0, kWarning = 1, kError = 2, kStale = 3 };
  Level level = Level::kOk;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace cloister::ros2
