#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "firmware_interface/files/mission_folder.hpp"
#include "firmware_interface/files/tum_file.hpp"
#include "firmware_interface/mission/mission_reader.hpp"
#include "firmware_interface/ros2/bag_for_tests.hpp"
#include "firmware_interface/ros2/driver_messages.hpp"
#include "firmware_interface/ros2/rosbag_mission.hpp"
#include "test/support/json.hpp"
#include "test/support/program.hpp"
#include "test/system/house_truth.hpp"

namespace cloister {
namespace {

/// The house as a robot with ROS 2 would have recorded it, every fourth scan. Returns the number of scans.
int record_house(const std::filesystem::path& path) {
  const auto folder = open_mission(CLOISTER_HOUSE_MISSION);
  REQUIRE(folder.has_value());
  BagWriter bag(path);
  const int points = bag.add_topic("/ouster/points", "sensor_msgs/msg/PointCloud2");
  const int odometry = bag.add_topic("/odometry", "nav_msgs/msg/Odometry");
  const int trajectory = bag.add_topic("/slam/path", "nav_msgs/msg/Path");
  const auto samples = load_tum(*folder->odometry_path);
  REQUIRE(samples.has_value());
  for (const StampedPose& sample : *samples) {
    bag.add(odometry, sample.stamp.ns, ros2::odometry_message(sample, "odom", "os_sensor").encode());
  }
  for (const GraphFile& file : folder->graphs) {
    const auto graph = load_graph(*folder, file, {});
    REQUIRE(graph.has_value());
    bag.add(trajectory, file.stamp.ns, ros2::path_message(*graph, "map").encode());
  }
  auto reader = MissionReader::open(CLOISTER_HOUSE_MISSION, Config{});
  REQUIRE(reader.has_value());
  int num_scans = 0;
  Scan scan;
  while (true) {
    const auto item = (*reader)->next(scan);
    REQUIRE(item.has_value());
    if (*item == MissionReader::Item::kEnd) return num_scans;
    if (*item == MissionReader::Item::kGraph || scan.index % 4 != 0) continue;
    bag.add(points, scan.stamp.ns, ros2::scan_message(scan, "os_sensor").encode());
    ++num_scans;
  }
}

TEST_CASE("the house recorded by ROS 2 replays as images, true to the world it was simulated in") {
  const TemporaryFolder folder;
  const auto bag = folder.path() / "house.db3";
  const int num_scans = record_house(bag);
  // Beam tables are found in the very first cloud.
  auto mission = ros2::RosbagMission::open(bag, 1 << 18);
  REQUIRE(mission.has_value());
  Scan scan;
  for (int i = 0; i < num_scans; ++i) {
    REQUIRE(mission->next_cloud(scan).value());
    REQUIRE(scan.kind == Scan::Kind::kOrganised);
  }
  const auto out = folder.path() / "out";
  const ProgramResult result =
      run_program(CLOISTER_PROGRAM, "replay " + bag.string() + " --out " + out.string());
  REQUIRE(result.exit_status == 0);
  CHECK(result.err.find("/slam/path has no covariances") != std::string::npos);
  const auto summary = read_json(out / "summary.json");
  CHECK(summary["scans"]["read"] == num_scans);
  CHECK(summary["scans"]["integrated"] == num_scans);
  CHECK(summary["drops"].empty());
  CHECK(summary["fusions"]["accepted"] == 0);

  check_truth_of_house(out);
}

}  // namespace
}  // namespace cloister
