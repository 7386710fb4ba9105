#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "firmware_interface/files/g2o_file.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// What a mission's scans are.
enum class MissionVariant {
  kPackets,  ///< lidar.pcap with metadata.json: Ouster packets, placed by odometry
  kClouds,   ///< individual_clouds/: one point cloud per graph node, in the cloud's own frame
};

/// Which frame the poses of odometry and graph are those of.
enum class PoseFrame {
  kSensor,  ///< the Ouster sensor frame, or the frame of the clouds: no transform is needed
  kLidar,   ///< the Ouster lidar frame, before `lidar_to_sensor_transform`
  kBody,    ///< another frame, in which MissionFolder::T_pose_sensor places the sensor
};

/// The stamp of a graph that was there before the mission began.
/// Half of the smallest, so that subtracting is safe.
inline constexpr SensorTime kBeforeMission{std::numeric_limits<std::int64_t>::min() / 2};

struct GraphFile {
  std::filesystem::path path;
  SensorTime stamp;  ///< when the SLAM system published it, from the file's name, or kBeforeMission
  std::int64_t number = 0;  ///< from the file's name
};

struct CloudFile {
  std::filesystem::path path;
  SensorTime stamp;  ///< from the file's name
};

/// What a mission directory holds, and its small parts.
/// Nothing that grows with the mission is read.
struct MissionFolder {
  std::filesystem::path path;
  std::string name;  ///< from mission.json, else the directory's name
  MissionVariant variant = MissionVariant::kPackets;

  std::filesystem::path packets_path;                  ///< lidar.pcap; kPackets only
  std::filesystem::path metadata_path;                 ///< metadata.json; kPackets only
  std::vector<CloudFile> clouds;                       ///< ascending stamps; kClouds only
  std::optional<std::filesystem::path> odometry_path;  ///< odometry.tum; always there for kPackets
  std::vector<GraphFile> graphs;                       ///< ascending (stamp, number); may be empty
  std::optional<std::filesystem::path> node_stamps_path;  ///< nodes.tum beside the graphs

  /// Applies to odometry and graph alike. For kPackets: with kSensor the pose of the sensor frame
  /// is the pose as written; with kLidar the writer's poses are of the lidar frame, so the sensor
  /// stands in it at the inverse of `lidar_to_sensor_transform`, which the caller takes from the
  /// metadata; with kBody it stands at `T_pose_sensor`. For kClouds "sensor" and "lidar" both mean
  /// the clouds' own frame.
  PoseFrame pose_frame = PoseFrame::kSensor;
  /// Pose of the sensor (of the clouds) in the pose frame: `T_O_L = T_O_pose * T_pose_sensor`. Set
  /// for kBody and identity for kSensor; empty for kLidar.
  std::optional<Pose> T_pose_sensor = Pose::Identity();

  std::vector<std::string> warnings;  ///< one line each: what is odd, but can be lived with
};

/// Looks through a mission directory:
///
///     lidar.pcap, metadata.json, odometry.tum        packets; or
///     individual_clouds/cloud_<sec>_<nsec>.pcd       clouds, with or without odometry.tum
///     pose_graph/NNNNNN_<stamp_ns>.g2o               snapshots; or
///     slam_pose_graph.slam, or one *.g2o or *.slam   a single graph, known from the start
///     nodes.tum                                      optional, in the folder of the graphs
///     mission.json                                   optional, see mission_json.hpp
///
/// A mission that holds packets and clouds is read as mission.json's `variant` says, else by its
/// packets. Snapshots in pose_graph/ go before a graph at the top. Files with other suffixes and
/// hidden ones are ignored.
/// @return kInput, naming the file, when something needed is missing,
///         or a name or mission.json is malformed
[[nodiscard]] Result<MissionFolder> open_mission(const std::filesystem::path& path);

/// Reads one of the mission's graphs: every node gets its stamp, by the graph or by nodes.tum, and
/// `PoseGraph::stamp` is that of the file. A graph without nodes is returned as such.
/// @return kInput with file:line as read_g2o, or naming the file when a node has no stamp
[[nodiscard]] Result<PoseGraph> load_graph(const MissionFolder& mission, const GraphFile& file,
                                           const G2oOptions& options, G2oStats* stats = nullptr);

}  // namespace cloister
