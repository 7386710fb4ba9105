#include "firmware_interface/ros2/rosbag_mission.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/mission/mission_reader.hpp"
#include "firmware_interface/ros2/bag_for_tests.hpp"

namespace cloister::ros2 {
namespace {

constexpr const char* kPoints = "sensor_msgs/msg/PointCloud2";
constexpr const char* kOdometry = "nav_msgs/msg/Odometry";
constexpr const char* kPath = "nav_msgs/msg/Path";
constexpr const char* kTransforms = "tf2_msgs/msg/TFMessage";

Pose at_x(double x) { return pose_of(x, 0, 0, 0); }

cdr::Bytes cloud_at(std::int32_t sec, const std::string& frame_id = "os_lidar") {
  cdr::Cloud cloud;
  cloud.sec = sec;
  cloud.frame_id = frame_id;
  cloud.points = {{1, 2, 3, 0, 0, 3742}, {0, 0, 0}, {4, 5, 6, 0, 0, 8775}};
  return cdr::write_cloud(cloud, false);
}

cdr::Bytes odometry_at(std::int32_t sec) { return cdr::write_odometry({sec, 0, at_x(sec)}, false); }

/// Five clouds a second apart, odometry around them, one path before the third and one after the last.
void write_mission(const std::filesystem::path& path, bool with_odometry = true,
                   bool with_transforms = true) {
  BagWriter bag(path);
  const int points = bag.add_topic("/ouster/points", kPoints);
  const int trajectory = bag.add_topic("/slam/path", kPath);
  bag.add_topic("/imu", "sensor_msgs/msg/Imu");
  constexpr std::int64_t kSecond = 1'000'000'000;
  constexpr std::int64_t kReceived = 500 * kSecond;  // by another clock
  if (with_odometry) {
    const int odometry = bag.add_topic("/odom", kOdometry);
    for (int sec = 9; sec <= 16; ++sec) {
      bag.add(odometry, kReceived + sec * kSecond, odometry_at(sec));
    }
    bag.add(odometry, kReceived + 16 * kSecond + 1, {std::byte{0}, std::byte{1}});
  }
  if (with_transforms) {
    const int transforms = bag.add_topic("/tf_static", kTransforms);
    // Late: it is needed before the first cloud all the same.
    bag.add(transforms, kReceived + 15 * kSecond,
            cdr::write_transforms({{"body", "os_sensor", pose_of(0, 0, 0.5, 0)},
                                   {"os_sensor", "os_lidar", pose_of(0, 0, 0.1, 0)}},
                                  true));
  }
  for (int sec = 14; sec >= 10; --sec) {  // rows need not be in order
    bag.add(points, kReceived + sec * kSecond + 100, cloud_at(sec));
  }
  bag.add(points, kReceived + 13 * kSecond, cdr::Bytes(40));
  bag.add(trajectory, kReceived + 11 * kSecond + 500,
          cdr::write_path(11, 0, {{10, 0, at_x(100)}, {11, 0, at_x(101)}}, true));
  bag.add(trajectory, kReceived + 12 * kSecond, cdr::write_path(11, 0, {}, false));
  bag.add(trajectory, kReceived + 15 * kSecond,
          cdr::write_path(15, 0,
                          {{10, 0, at_x(200)},
                           {11, 0, at_x(201)},
                           {12, 0, at_x(202)},
                           {13, 0, at_x(203)},
                           {14, 0, at_x(204)}},
                          false));
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

TEST_CASE("a recording replays as the robot saw it: clouds placed by odometry, paths in between") {
  const ScratchDirectory folder;
  write_mission(folder / "walk_0.db3");
  for (const auto& path : {folder / "walk_0.db3", folder.path()}) {
    CAPTURE(path);
    auto reader = MissionReader::open(path, Config{});
    REQUIRE_MESSAGE(reader.has_value(), (reader ? "" : reader.error().message));
    CHECK((*reader)->num_scans_expected() == 6);
    std::vector<std::string> items;
    std::vector<double> places;
    Scan scan;
    while (true) {
      const auto item = (*reader)->next(scan);
      REQUIRE(item.has_value());
      if (*item == MissionReader::Item::kEnd) break;
      if (*item == MissionReader::Item::kGraph) {
        const auto revision = (*reader)->take_graph();
        items.push_back("graph " + std::to_string(revision->graph.nodes.size()));
        CHECK(revision->T_O_N[1].has_value());
        CHECK(revision->new_loops.empty());
        continue;
      }
      items.push_back("scan " + std::to_string(scan.stamp.ns / 1'000'000'000));
      CHECK(scan.points_L.size() == 2);
      REQUIRE(scan.T_O_L.has_value());
      CHECK(scan.T_O_L->translation().isApprox(
          Eigen::Vector3d(static_cast<double>(scan.stamp.ns) * 1e-9, 0, 0.6), 1e-9));
    }
    CHECK(items == std::vector<std::string>{"scan 10", "scan 11", "graph 2", "scan 12", "scan 13",
                                            "scan 14", "graph 5"});
    CHECK((*reader)->num_scans_read() == 5);
    CHECK((*reader)->num_returns_read() == 10);
    auto drops = (*reader)->drops();
    CHECK(drops["ros2_unknown_encapsulation"] == 1);
    CHECK(drops["ros2_malformed_message"] == 1);
    CHECK(drops["path_empty"] == 1);
    REQUIRE((*reader)->warnings().size() == 1);
    CHECK((*reader)->warnings()[0].find("fuse_without_covariance") != std::string::npos);
  }
}

TEST_CASE("without odometry clouds wait for the path that brings their nodes") {
  const ScratchDirectory folder;
  write_mission(folder / "nodes.db3", false, false);
  auto reader = MissionReader::open(folder / "nodes.db3", Config{});
  REQUIRE(reader.has_value());
  std::string items;
  Scan scan;
  while (true) {
    const auto item = (*reader)->next(scan);
    REQUIRE(item.has_value());
    if (*item == MissionReader::Item::kEnd) break;
    if (*item == MissionReader::Item::kGraph) {
      items += "g";
      CHECK((*reader)->take_graph() != nullptr);
    } else {
      items += "s";
      CHECK(scan.node == scan.stamp.ns / 1'000'000'000 - 10);
    }
  }
  CHECK(items == "gssgsss");
  CHECK((*reader)->num_scans_unplaced() == 0);
}

TEST_CASE(
    "mission.json says where the sensor sits, which topics to take, and what the mission is "
    "called") {
  const ScratchDirectory folder;
  const auto bag_path = folder / "bag.db3";
  write_mission(bag_path, true, false);
  auto refused = RosbagMission::open(folder.path(), 1000);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().kind == ErrorKind::kInput);
  CHECK(refused.error().message.find("from body (odometry) to os_lidar (/ouster/points)") !=
        std::string::npos);

  write_text(folder / "mission.json", R"({"T_pose_sensor": [1, 2, 3, 0, 0, 0, 1]})");
  auto mission = RosbagMission::open(folder.path(), 1000);
  REQUIRE(mission.has_value());
  CHECK(mission->T_body_cloud().translation() == Eigen::Vector3d(1, 2, 3));
  CHECK(RosbagMission::open(bag_path, 1000)->T_body_cloud().translation().x() == 1);

  {
    std::filesystem::remove(bag_path);
    BagWriter bag(bag_path);
    bag.add(bag.add_topic("/camera/points", kPoints), 1, cloud_at(1, "camera"));
    bag.add(bag.add_topic("/ouster/points", kPoints), 1, cloud_at(2, "body"));
    bag.add(bag.add_topic("/odom", kOdometry), 1, odometry_at(1));
  }
  write_text(folder / "mission.json", "{}");
  refused = RosbagMission::open(bag_path, 1000);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message.find("several topics of sensor_msgs/msg/PointCloud2: "
                                     "/camera/points, /ouster/points") != std::string::npos);
  write_text(folder / "mission.json", R"({"name": "yard", "points_topic": "/ouster/points"})");
  mission = RosbagMission::open(bag_path, 1000);
  REQUIRE(mission.has_value());
  CHECK(mission->name() == "yard");
  CHECK(mission->num_clouds() == 1);
  CHECK(mission->T_body_cloud().isApprox(Pose::Identity()));  // one frame needs no transform
  write_text(folder / "mission.json", R"({"points_topic": "/velodyne"})");
  CHECK(RosbagMission::open(bag_path, 1000).error().message.find("on /velodyne (it has: /camera") !=
        std::string::npos);
}

TEST_CASE("a recording in several files is one mission") {
  const ScratchDirectory folder;
  {
    BagWriter first(folder / "walk_0.db3");
    first.add_topic("/odom", kOdometry);
    const int points = first.add_topic("/points", kPoints);
    first.add(points, 10, cloud_at(10, "body"));
    first.add(points, 30, cloud_at(30, "body"));
    BagWriter second(folder / "walk_1.db3");
    const int other_points = second.add_topic("/points", kPoints);
    second.add(second.add_topic("/odom", kOdometry), 20, odometry_at(20));
    second.add(other_points, 20, cloud_at(20, "body"));
  }
  auto mission = RosbagMission::open(folder.path(), 1000);
  REQUIRE(mission.has_value());
  Scan scan;
  for (const std::int64_t sec : {10, 20, 30}) {
    REQUIRE(mission->next_cloud(scan).value());
    CHECK(scan.stamp.ns == sec * 1'000'000'000);
  }
  CHECK_FALSE(mission->next_cloud(scan).value());
}

TEST_CASE("what is no recording, lacks something or is compressed is refused with its name") {
  const ScratchDirectory folder;
  const auto refusal = [&](const std::filesystem::path& path) {
    const auto reader = MissionReader::open(path, Config{});
    REQUIRE_FALSE(reader.has_value());
    CHECK(reader.error().kind == ErrorKind::kInput);
    CHECK(reader.error().message.find(path.filename().string()) != std::string::npos);
    return reader.error().message;
  };
  CHECK(refusal(folder / "missing.db3").find("no such recording") != std::string::npos);
  write_text(folder / "text.db3", std::string(4096, 'x'));
  CHECK(refusal(folder / "text.db3").find("not a database") != std::string::npos);
  write_text(folder / "empty.db3", "");
  CHECK(refusal(folder / "empty.db3").find("messages") != std::string::npos);
  {
    BagWriter bag(folder / "lonely.db3");
    bag.add_topic("/points", kPoints);
  }
  CHECK(refusal(folder / "lonely.db3").find("holds no nav_msgs/msg/Odometry") != std::string::npos);
  {
    BagWriter bag(folder / "packed.db3");
    bag.add_topic("/points", kPoints);
    bag.add(bag.add_topic("/odom", kOdometry), 1,
            {std::byte{0x28}, std::byte{0xb5}, std::byte{0x2f}, std::byte{0xfd}, std::byte{0}});
  }
  CHECK(refusal(folder / "packed.db3").find("compressed") != std::string::npos);
}

TEST_CASE("a file cut off in the middle ends in an error that names it, not in a crash") {
  const ScratchDirectory folder;
  const auto path = folder / "bag.db3";
  write_mission(path);
  const auto size = std::filesystem::file_size(path);
  int num_refused = 0;
  for (std::uintmax_t kept = 512; kept < size; kept += 1024) {
    std::filesystem::remove(path);
    write_mission(path);
    std::filesystem::resize_file(path, kept);
    auto reader = MissionReader::open(path, Config{});
    if (!reader) {
      ++num_refused;
      continue;
    }
    Scan scan;
    for (int i = 0; i < 20; ++i) {
      const auto item = (*reader)->next(scan);
      if (!item) {
        CHECK(item.error().message.find("bag.db3") != std::string::npos);
        ++num_refused;
      }
      if (!item || *item == MissionReader::Item::kEnd) break;
    }
  }
  CHECK(num_refused > 0);
}

}  // namespace
}  // namespace cloister::ros2
