#include "firmware_interface/ros2/rosbag_mission.hpp"

#include <algorithm>

#include "firmware_interface/files/mission_json.hpp"
#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/ros2/message_parts.hpp"
#include "firmware_interface/ros2/static_transforms.hpp"

namespace cloister::ros2 {
namespace {

constexpr const char* kPointsType = "sensor_msgs/msg/PointCloud2";
constexpr const char* kOdometryType = "nav_msgs/msg/Odometry";
constexpr const char* kPathType = "nav_msgs/msg/Path";
constexpr const char* kTransformsType = "tf2_msgs/msg/TFMessage";

/// mission.json in the recording's folder, or in that of its only file; empty where there is none.
Result<MissionJson> load_mission_json(const std::filesystem::path& recording) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(recording, error);
  const auto path = (is_folder ? recording : recording.parent_path()) / "mission.json";
  if (!std::filesystem::is_regular_file(path, error)) return MissionJson{};
  auto text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  return read_mission_json(*text, path.string());
}

/// The topic of a type: the one that was asked for, else the only one; empty when there is none.
Result<std::string> find_topic(const RosbagFile& bag, const std::filesystem::path& path,
                               const std::string& type, const char* key,
                               const std::optional<std::string>& wanted) {
  std::string names;
  std::string found;
  std::size_t count = 0;
  for (const BagTopic& topic : bag.topics()) {
    if (topic.type != type) continue;
    if (wanted == topic.name) return topic.name;
    found = topic.name;
    names += (names.empty() ? "" : ", ") + topic.name;
    ++count;
  }
  if (!wanted && count <= 1) return found;
  const std::string said = wanted ? "has no " + type + " on " + *wanted + " (it has: " + names + ")"
                                  : "has several topics of " + type + ": " + names;
  return fail(ErrorKind::kInput,
              path.string() + ": " + said + "; name one as " + key + " in mission.json");
}

}  // namespace

Result<RosbagMission> RosbagMission::open(const std::filesystem::path& path,
                                          std::size_t max_points) {
  auto bag = RosbagFile::open(path);
  if (!bag) return tl::unexpected(bag.error());
  const auto json = load_mission_json(path);
  if (!json) return tl::unexpected(json.error());
  const auto points = find_topic(*bag, path, kPointsType, "points_topic", json->points_topic);
  if (!points) return tl::unexpected(points.error());
  const auto odometry =
      find_topic(*bag, path, kOdometryType, "odometry_topic", json->odometry_topic);
  if (!odometry) return tl::unexpected(odometry.error());
  const auto trajectory = find_topic(*bag, path, kPathType, "path_topic", json->path_topic);
  if (!trajectory) return tl::unexpected(trajectory.error());
  if (points->empty() || (odometry->empty() && trajectory->empty())) {
    return fail(ErrorKind::kInput,
                path.string() + ": holds no " +
                    (points->empty() ? std::string(kPointsType)
                                     : std::string(kOdometryType) + " and no " + kPathType) +
                    "; record it with the others");
  }
  RosbagMission mission(std::move(*bag), max_points, odometry->empty());
  const auto stem = std::filesystem::absolute(path).lexically_normal();
  mission.name_ =
      json->name.value_or((stem.has_filename() ? stem : stem.parent_path()).stem().string());
  auto clouds = mission.bag_.messages(*points);
  if (!clouds) return tl::unexpected(clouds.error());
  mission.clouds_ = std::move(*clouds);
  if (!trajectory->empty()) {
    auto paths = mission.bag_.messages(*trajectory);
    if (!paths) return tl::unexpected(paths.error());
    mission.paths_ = std::move(*paths);
  }
  if (auto read = mission.read_odometry(*odometry); !read) return tl::unexpected(read.error());
  if (json->T_pose_sensor) {
    mission.T_body_cloud_ = *json->T_pose_sensor;
  } else if (auto found = mission.find_sensor(*points); !found) {
    return tl::unexpected(found.error());
  }
  if (!mission.paths_.empty()) {
    mission.warnings_.push_back(warning_without_covariances(*trajectory));
  }
  return mission;
}

Result<void> RosbagMission::read_odometry(const std::string& topic) {
  if (topic.empty()) return {};
  const auto entries = bag_.messages(topic);
  if (!entries) return tl::unexpected(entries.error());
  Message<Odometry> message;
  for (const RosbagFile::Entry& entry : *entries) {
    const auto data = bag_.data(entry);
    if (!data) return tl::unexpected(data.error());
    if (!message.decode(*data, counters_)) continue;
    if (const auto pose = odometry_decoder_.pose(*message, counters_)) odometry_.push_back(*pose);
  }
  std::ranges::stable_sort(odometry_, {}, &StampedPose::stamp);
  const auto copies = std::ranges::unique(odometry_, {}, &StampedPose::stamp);
  odometry_.erase(copies.begin(), copies.end());
  has_odometry_ = !odometry_.empty();
  if (!has_odometry_) {
    return fail(ErrorKind::kInput, topic + ": holds no pose that can be used; record it again");
  }
  return {};
}

Result<void> RosbagMission::find_sensor(const std::string& points_topic) {
  if (!has_odometry_) return {};
  std::string frame;
  for (const RosbagFile::Entry& entry : clouds_) {
    const auto data = bag_.data(entry);
    if (!data) return tl::unexpected(data.error());
    MessageCounters uncounted;  // it is read again later
    if (!cloud_.decode(*data, uncounted)) continue;
    frame = frame_name(cloud_->header.frame_id);
    break;
  }
  StaticTransforms transforms;
  Message<TFMessage> message;
  for (const BagTopic& topic : bag_.topics()) {
    if (topic.type != kTransformsType || !topic.name.ends_with("tf_static")) continue;
    const auto entries = bag_.messages(topic.name);
    if (!entries) return tl::unexpected(entries.error());
    for (const RosbagFile::Entry& entry : *entries) {
      const auto data = bag_.data(entry);
      if (!data) return tl::unexpected(data.error());
      if (message.decode(*data, counters_)) transforms.add(*message, counters_);
    }
  }
  const auto T_body_cloud = transforms.find(odometry_decoder_.body_frame(), frame);
  if (!T_body_cloud) {
    return fail(ErrorKind::kInput,
                "no static transform from " + odometry_decoder_.body_frame() + " (odometry) to " +
                    frame + " (" + points_topic +
                    "); record /tf_static, or give T_pose_sensor in mission.json");
  }
  T_body_cloud_ = *T_body_cloud;
  return {};
}

Result<bool> RosbagMission::next_cloud(Scan& scan) {
  while (next_cloud_ < clouds_.size()) {
    const RosbagFile::Entry& entry = clouds_[next_cloud_++];
    const auto data = bag_.data(entry);
    if (!data) return tl::unexpected(data.error());
    cloud_received_ns_ = entry.received_ns;
    if (cloud_.decode(*data, counters_) && clouds_decoder_.scan(*cloud_, counters_, scan)) {
      return true;
    }
  }
  return false;
}

Result<std::optional<PoseGraph>> RosbagMission::next_path() {
  const auto data = bag_.data(paths_[next_path_++]);
  if (!data) return tl::unexpected(data.error());
  if (!path_.decode(*data, counters_)) return std::nullopt;
  return path_decoder_.graph(*path_, counters_);
}

}  // namespace cloister::ros2
