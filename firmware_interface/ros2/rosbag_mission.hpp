#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/files/stamped_pose.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/odometry_message.hpp"
#include "firmware_interface/ros2/path_message.hpp"
#include "firmware_interface/ros2/point_cloud_message.hpp"
#include "firmware_interface/ros2/rosbag_file.hpp"
#include "mapping/core/result.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister::ros2 {

/// A rosbag2 recording as a mission: the clouds, the odometry and the re-optimised trajectory of one robot.
///
/// Topics are found by type: the PointCloud2, the Odometry and the Path; where there are several of a type,
/// `points_topic`, `odometry_topic` and `path_topic` of a mission.json beside the recording say which. Odometry or a
/// path may be missing, not both.
///
/// The pose of the clouds' frame in the odometry's `child_frame_id` comes from mission.json's `T_pose_sensor`, else
/// from /tf_static. Without odometry the path's poses are taken to be those of the clouds' own frame, unless
/// `T_pose_sensor` says otherwise, and every cloud as points, placed by the node with its stamp.
///
/// Odometry is read when the recording is opened, clouds and paths one by one, in the order they were received.
/// Messages that cannot be used are counted and passed over.
///
/// Threads: one at a time.
class RosbagMission {
 public:
  /// @return kInput, naming the file or topic, when something that is needed is missing or ambiguous
  [[nodiscard]] static Result<RosbagMission> open(const std::filesystem::path& path,
                                                  std::size_t max_points);

  /// Name from mission.json, else of the file or folder.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The odometry, by stamp; to be taken once.
  [[nodiscard]] std::vector<StampedPose> take_odometry() { return std::move(odometry_); }
  [[nodiscard]] bool has_odometry() const { return has_odometry_; }
  /// The clouds' frame in the frame whose poses odometry and path hold.
  [[nodiscard]] const Pose& T_body_cloud() const { return T_body_cloud_; }
  /// How many clouds there are.
  [[nodiscard]] std::int64_t num_clouds() const {
    return static_cast<std::int64_t>(clouds_.size());
  }

  /// Reads on to the next cloud that can be used, as PointCloudDecoder does.
  /// @return false at the end
  [[nodiscard]] Result<bool> next_cloud(Scan& scan);

  [[nodiscard]] bool has_path() const { return next_path_ < paths_.size(); }
  /// Whether the next path was received before the cloud that was read last.
  [[nodiscard]] bool path_is_due() const {
    return has_path() && paths_[next_path_].received_ns <= cloud_received_ns_;
  }
  /// Reads the next path. @return nothing when it cannot be used
  [[nodiscard]] Result<std::optional<PoseGraph>> next_path();

  [[nodiscard]] const MessageCounters& counters() const { return counters_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  RosbagMission(RosbagFile bag, std::size_t max_points, bool clouds_only)
      : bag_(std::move(bag)), clouds_decoder_(max_points, clouds_only) {}

  [[nodiscard]] Result<void> read_odometry(const std::string& topic);
  [[nodiscard]] Result<void> find_sensor(const std::string& points_topic);

  RosbagFile bag_;
  std::string name_;
  std::vector<RosbagFile::Entry> clouds_;
  std::vector<RosbagFile::Entry> paths_;
  std::size_t next_cloud_ = 0;
  std::size_t next_path_ = 0;
  std::int64_t cloud_received_ns_ = 0;
  bool has_odometry_ = false;
  std::vector<StampedPose> odometry_;
  Pose T_body_cloud_ = Pose::Identity();
  Message<PointCloud2> cloud_;
  Message<Path> path_;
  PointCloudDecoder clouds_decoder_;
  OdometryDecoder odometry_decoder_;
  PathDecoder path_decoder_;
  MessageCounters counters_;
  std::vector<std::string> warnings_;
};

}  // namespace cloister::ros2
