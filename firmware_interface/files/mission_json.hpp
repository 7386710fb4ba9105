#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "firmware_interface/files/mission_folder.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// What mission.json may say; keys not listed here are for people.
struct MissionJson {
  std::optional<std::string> name;
  std::optional<MissionVariant> variant;
  PoseFrame pose_frame = PoseFrame::kSensor;
  std::optional<Pose> T_pose_sensor;  ///< set exactly for PoseFrame::kBody
  // Of a rosbag2 recording that has several topics of a type.
  std::optional<std::string> points_topic;
  std::optional<std::string> odometry_topic;
  std::optional<std::string> path_topic;
};

/// Reads mission.json:
///
///     name            any text
///     variant         "pcap" or "individual_clouds"
///     pose_frame      "sensor" or "lidar"
///     points_topic, odometry_topic, path_topic
///                     topics of a rosbag2 recording, as "/ouster/points"
///     T_pose_sensor   [x,y,z,qx,qy,qz,qw], or a 4x4 matrix by rows, nested or flat; metres
///
/// `T_pose_sensor` decides when it is there; `pose_frame` may then hold any name.
/// @return kInput with file:line when it is no JSON object, or a known key has an unknown value
[[nodiscard]] Result<MissionJson> read_mission_json(std::string_view text,
                                                    std::string_view file_name);

}  // namespace cloister
