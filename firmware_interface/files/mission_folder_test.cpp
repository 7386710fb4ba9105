#include "firmware_interface/files/mission_folder.hpp"

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/files/mission_json.hpp"
#include "firmware_interface/files/test_files.hpp"

namespace cloister {
namespace {

using test::TemporaryFolder;

/// What a mission of packets needs, empty.
void write_packet_mission(const TemporaryFolder& folder) {
  for (const char* name : {"lidar.pcap", "metadata.json", "odometry.tum"}) folder.write(name);
}

TEST_CASE("the sample missions are opened") {
  const std::string missions = CLOISTER_TEST_DATA "/missions/";
  const auto packets = open_mission(missions + "os1-128-3scans/");
  REQUIRE(packets);
  CHECK(packets->name == "os1-128-3scans");
  CHECK(packets->variant == MissionVariant::kPackets);
  CHECK(packets->pose_frame == PoseFrame::kSensor);
  CHECK(std::filesystem::exists(packets->packets_path));
  CHECK(std::filesystem::exists(packets->metadata_path));
  REQUIRE(packets->odometry_path);
  REQUIRE(packets->graphs.size() == 1);
  CHECK(packets->graphs[0].stamp.ns == 991837352610);
  CHECK(packets->warnings.empty());
  const auto graph = load_graph(*packets, packets->graphs[0], {});
  REQUIRE(graph);
  CHECK(graph->nodes.size() == 3);
  CHECK(graph->stamp.ns == 991837352610);
  CHECK(open_mission(missions + "os1-64-capture"));

  const auto clouds = open_mission(missions + "norlab");
  REQUIRE(clouds);
  CHECK(clouds->variant == MissionVariant::kClouds);
  CHECK(clouds->pose_frame == PoseFrame::kSensor);
  CHECK(clouds->T_pose_sensor->isApprox(Pose::Identity()));
  REQUIRE(clouds->clouds.size() == 14);
  CHECK(clouds->clouds[8].path.filename() == "cloud_1690309710_85582848.pcd");
  CHECK(clouds->clouds[8].stamp.ns == 1690309710085582848);
  REQUIRE(clouds->graphs.size() == 1);
  CHECK(clouds->graphs[0].stamp == kBeforeMission);
  CHECK_FALSE(clouds->odometry_path);
}

TEST_CASE("snapshots come in the order of their stamps, then their numbers") {
  const TemporaryFolder folder;
  write_packet_mission(folder);
  for (const char* name : {"000000_900.g2o", "000001_1000.g2o", "000003_20.g2o", "000002_20.g2o",
                           "notes.txt", "nodes.tum", ".000009_5.g2o", "000004_7.g2o.tmp"}) {
    folder.write(std::string("pose_graph/") + name);
  }
  folder.write("older.g2o");
  const auto mission = open_mission(folder.path());
  REQUIRE(mission);
  REQUIRE(mission->graphs.size() == 4);
  CHECK(mission->graphs[0].number == 2);
  CHECK(mission->graphs[1].number == 3);
  CHECK(mission->graphs[2].stamp.ns == 900);
  CHECK(mission->graphs[3].stamp.ns == 1000);
  CHECK(mission->node_stamps_path == folder.path() / "pose_graph" / "nodes.tum");
  CHECK(mission->name == folder.path().filename());
}

TEST_CASE("packets with odometry but without a graph are a mission, with a warning") {
  const TemporaryFolder folder;
  write_packet_mission(folder);
  std::filesystem::create_directory(folder.path() / "pose_graph");
  const auto mission = open_mission(folder.path());
  REQUIRE(mission);
  CHECK(mission->graphs.empty());
  REQUIRE(mission->warnings.size() == 1);
  CHECK(test::contains(mission->warnings[0], "no pose graph"));
}

TEST_CASE("clouds need a graph or odometry, and any of both will do") {
  const TemporaryFolder folder;
  folder.write("individual_clouds/cloud_1_5.pcd");
  CHECK(test::contains(open_mission(folder.path()).error().message,
                       "holds no pose graph and no odometry.tum"));
  SUBCASE("odometry") {
    folder.write("odometry.tum");
    CHECK(open_mission(folder.path())->warnings.size() == 1);
  }
  SUBCASE("a graph by any name") {
    folder.write("final.g2o");
    CHECK(open_mission(folder.path())->graphs.size() == 1);
    folder.write("other.slam");
    CHECK(test::contains(open_mission(folder.path()).error().message,
                         "is a second graph beside final.g2o"));
    folder.write("slam_pose_graph.slam");
    CHECK(open_mission(folder.path())->graphs[0].path.filename() == "slam_pose_graph.slam");
  }
}

TEST_CASE("a mission that holds both is read by its packets unless it says otherwise") {
  const TemporaryFolder folder;
  write_packet_mission(folder);
  folder.write("individual_clouds/cloud_1_5.pcd");
  CHECK(open_mission(folder.path())->variant == MissionVariant::kPackets);
  CHECK(open_mission(folder.path())->warnings.size() == 2);
  folder.write("mission.json", R"({"variant": "individual_clouds"})");
  CHECK(open_mission(folder.path())->variant == MissionVariant::kClouds);
}

TEST_CASE("what is missing or misnamed is said by name") {
  const TemporaryFolder folder;
  const auto message = [&folder] {
    const auto mission = open_mission(folder.path());
    REQUIRE_FALSE(mission);
    CHECK(mission.error().kind == ErrorKind::kInput);
    return mission.error().message;
  };
  CHECK(test::contains(open_mission(folder.path() / "none").error().message,
                       "none: is not a directory"));
  CHECK(test::contains(message(), "holds neither lidar.pcap nor individual_clouds/"));
  SUBCASE("packets") {
    folder.write("lidar.pcap");
    CHECK(test::contains(message(), "metadata.json: is missing"));
    folder.write("metadata.json");
    CHECK(test::contains(message(), "odometry.tum: is missing"));
    folder.write("odometry.tum");
    CHECK(open_mission(folder.path()));
    for (const char* name : {"12.g2o", "_12.g2o", "12_.g2o", "a_12.g2o", "1_-2.g2o", "1_2_3.g2o",
                             "1_99999999999999999999.g2o", "1_4000000000000000001.g2o"}) {
      CAPTURE(name);
      const auto path = folder.write(std::string("pose_graph/") + name);
      CHECK(
          test::contains(message(), std::string(name) + ": the name is not NNNNNN_<stamp_ns>.g2o"));
      std::filesystem::remove(path);
    }
    folder.write("mission.json", R"({"variant": "individual_clouds"})");
    CHECK(test::contains(message(), "individual_clouds: is missing"));
  }
  SUBCASE("clouds") {
    std::filesystem::create_directory(folder.path() / "individual_clouds");
    CHECK(test::contains(message(), "individual_clouds: holds no cloud_<sec>_<nsec>.pcd"));
    for (const char* name : {"cloud.pcd", "cloud_1.pcd", "cloud_1_1000000000.pcd", "scan_1_2.pcd",
                             "cloud_1_2_3.pcd"}) {
      CAPTURE(name);
      const auto path = folder.write(std::string("individual_clouds/") + name);
      CHECK(test::contains(message(),
                           std::string(name) + ": the name is not cloud_<sec>_<nsec>.pcd"));
      std::filesystem::remove(path);
    }
    folder.write("individual_clouds/cloud_1_5.pcd");
    folder.write("individual_clouds/cloud_1_000000005.pcd");
    CHECK(test::contains(message(), "has the stamp of another cloud"));
    folder.write("mission.json", R"({"variant": "pcap"})");
    CHECK(test::contains(message(), "lidar.pcap: is missing"));
  }
}

TEST_CASE("mission.json places the sensor in the frame of the poses") {
  const TemporaryFolder folder;
  write_packet_mission(folder);
  folder.write("mission.json", R"({"pose_frame": "lidar", "name": "yard"})");
  const auto lidar = open_mission(folder.path());
  REQUIRE(lidar);
  CHECK(lidar->name == "yard");
  CHECK(lidar->pose_frame == PoseFrame::kLidar);
  CHECK_FALSE(lidar->T_pose_sensor);

  const Pose expected = make_pose({1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(
                                                 std::acos(-1.0) / 2, Eigen::Vector3d::UnitZ())));
  for (
      const char* text :
      {R"({"pose_frame": "imu", "T_pose_sensor": [1, 2, 3, 0, 0, 0.70710678118654757, 0.70710678118654757]})",
       R"({"T_pose_sensor": [[0,-1,0,1],[1,0,0,2],[0,0,1,3],[0,0,0,1]]})",
       R"({"T_pose_sensor": [0,-1,0,1,1,0,0,2,0,0,1,3,0,0,0,1]})"}) {
    CAPTURE(text);
    folder.write("mission.json", text);
    const auto body = open_mission(folder.path());
    REQUIRE(body);
    CHECK(body->pose_frame == PoseFrame::kBody);
    CHECK(body->T_pose_sensor->isApprox(expected, 1e-12));
  }
}

TEST_CASE("a malformed mission.json is refused with its line") {
  struct Row {
    const char* text;
    const char* message;
  };
  for (const Row& row :
       {Row{"", "m.json:1: the text is not JSON"},
        Row{"{\n\"name\": \"a\",\n}", "m.json:3: the text is not JSON here"},
        Row{"{\"a\": 1e999}", "m.json:1: the text is not JSON"},
        Row{"[1]", "m.json:1: the text is not a JSON object"},
        Row{"{\n\n\"name\": 5}", "m.json:3: name is not a string"},
        Row{"{\n\"variant\": \"bag\"}", "m.json:2: variant is neither"},
        Row{"{\n\"pose_frame\": \"imu\"}", "m.json:2: pose_frame is neither"},
        Row{"{\n\"pose_frame\": 3}", "m.json:2: pose_frame is neither"},
        Row{"{\"name\": \"a\",\n\"T_pose_sensor\": [1,2,3]}", "m.json:2: T_pose_sensor is neither"},
        Row{"{\"T_pose_sensor\": [1,2,3,0,0,0,0]}", "m.json:1: T_pose_sensor is neither"},
        Row{"{\"T_pose_sensor\": [1,2,3,0,0,0,\"1\"]}", "m.json:1: T_pose_sensor is neither"},
        Row{"{\"T_pose_sensor\": {}}", "m.json:1: T_pose_sensor is neither"},
        Row{"{\"T_pose_sensor\": [[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]}",
            "m.json:1: T_pose_sensor is neither"},
        Row{"{\"T_pose_sensor\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]}",
            "m.json:1: T_pose_sensor is neither"}}) {
    CAPTURE(row.text);
    const auto mission = read_mission_json(row.text, "m.json");
    REQUIRE_FALSE(mission);
    CHECK(mission.error().kind == ErrorKind::kInput);
    CHECK(mission.error().message.starts_with(row.message));
  }
}

TEST_CASE("a graph without stamps takes them from nodes.tum") {
  const TemporaryFolder folder;
  write_packet_mission(folder);
  folder.write("pose_graph/000000_77.g2o",
               "VERTEX_SE3:QUAT 4 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 2 0 0 0 0 0 0 1\n");
  const auto without = open_mission(folder.path());
  REQUIRE(without);
  const auto refused = load_graph(*without, without->graphs[0], {});
  REQUIRE_FALSE(refused);
  CHECK(test::contains(refused.error().message, "000000_77.g2o: vertex 2 has no stamp"));

  folder.write("pose_graph/nodes.tum", "1.5 0 0 0 0 0 0 1\n2.5 0 0 0 0 0 0 1\n3.5 0 0 0 0 0 0 1\n");
  const auto mission = open_mission(folder.path());
  const auto graph = load_graph(*mission, mission->graphs[0], {});
  REQUIRE(graph);
  CHECK(graph->stamp.ns == 77);
  CHECK(graph->nodes[0].stamp.ns == 1'500'000'000);
  CHECK(graph->nodes[1].stamp.ns == 2'500'000'000);

  folder.write("pose_graph/nodes.tum", "1.5 0 0 0 0 0 0 1\n");
  CHECK(test::contains(load_graph(*mission, mission->graphs[0], {}).error().message,
                       "nodes.tum:1: "));
  folder.write("pose_graph/nodes.tum", "1.5 0 0 0\n");
  CHECK(test::contains(load_graph(*mission, mission->graphs[0], {}).error().message,
                       "nodes.tum:1: "));
}

}  // namespace
}  // namespace cloister
