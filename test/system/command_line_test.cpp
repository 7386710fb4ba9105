#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "test/support/program.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

ProgramResult cloister_program(const std::string& arguments) { return run_program(CLOISTER_PROGRAM, arguments); }

bool is_one_line(const std::string& text) { return std::count(text.begin(), text.end(), '\n') == 1; }

/// A copy of a small recorded mission that a test may break.
fs::path copy_mission(const char* name, const fs::path& folder) {
  fs::copy(fs::path(CLOISTER_TEST_DATA) / "missions" / name, folder / "mission", fs::copy_options::recursive);
  return folder / "mission";
}

void write_text(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

TEST_CASE("help lists every command with a line, and succeeds") {
  const ProgramResult help = cloister_program("--help");
  CHECK(help.exit_status == 0);
  for (const char* command : {"replay", "simulate", "query", "export", "uncertainty", "config"}) {
    CAPTURE(command);
    CHECK(help.out.find(command) != std::string::npos);
    CHECK(cloister_program(std::string(command) + " --help").exit_status == 0);
  }
  CHECK(cloister_program("--version").out.find("cloister 0.") == 0);
}

TEST_CASE("a wrong command line exits with 2 and one line") {
  for (const char* arguments : {"", "fly", "replay", "replay a", "replay a --out b --fast", "export a"}) {
    CAPTURE(arguments);
    const ProgramResult result = cloister_program(arguments);
    CHECK(result.exit_status == 2);
    CHECK(is_one_line(result.err));
  }
}

TEST_CASE("a wrong setting exits with 2 and names field, value and bound") {
  const TemporaryFolder folder;
  const auto out = (folder.path() / "out").string();
  const ProgramResult bound =
      cloister_program("replay " + std::string(CLOISTER_HOUSE_MISSION) + " --out " + out + " --set voxel.voxel_size_m=7");
  CHECK(bound.exit_status == 2);
  CHECK(bound.err.find("voxel.voxel_size_m = 7") != std::string::npos);
  CHECK(bound.err.find("between 0.01 and 1") != std::string::npos);
  for (const char* setting : {"voxel.nonsense=1", "voxel", "voxel.voxel_size_m=big", "memory.max_submaps=2.5", "=", "baseline=3"}) {
    CAPTURE(setting);
    const ProgramResult result = cloister_program("config --set '" + std::string(setting) + "'");
    CHECK(result.exit_status == 2);
    CHECK(is_one_line(result.err));
  }
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("a configuration file is read, and refused with its line") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "c.toml";
  write_text(file, "baseline = true\n[spawn]\nmin_overlap = 0.5\n");
  const ProgramResult good = cloister_program("config --config " + file.string() + " --set spawn.filter_m=0.3");
  CHECK(good.exit_status == 0);
  CHECK(good.out.find("baseline = true") != std::string::npos);
  CHECK(good.out.find("min_overlap = 0.5") != std::string::npos);
  CHECK(good.out.find("filter_m = 0.3") != std::string::npos);
  // What the program prints, it reads back to the same.
  write_text(file, good.out);
  CHECK(cloister_program("config --config " + file.string()).out == good.out);
  write_text(file, "[spawn]\nmin_overlap = 3\n");
  const ProgramResult bad = cloister_program("config --config " + file.string());
  CHECK(bad.exit_status == 2);
  CHECK(bad.err.find("c.toml:2: spawn.min_overlap = 3") != std::string::npos);
  write_text(file, "[spawn\n");
  CHECK(cloister_program("config --config " + file.string()).exit_status == 2);
  CHECK(cloister_program("config --config " + (folder.path() / "none.toml").string()).exit_status == 2);
}

TEST_CASE("missing or malformed mission files exit with 3, name file and place, and leave nothing behind") {
  struct Case {
    const char* name;
    const char* mission;
    void (*spoil)(const fs::path&);
    const char* named;
  };
  const std::vector<Case> cases = {
      {"no capture", "os1-64-capture", [](const fs::path& m) { fs::remove(m / "lidar.pcap"); }, "lidar.pcap"},
      {"empty capture", "os1-64-capture", [](const fs::path& m) { write_text(m / "lidar.pcap", ""); }, "lidar.pcap"},
      {"not a capture", "os1-64-capture", [](const fs::path& m) { write_text(m / "lidar.pcap", "hello, world, hello"); }, "lidar.pcap"},
      {"no metadata", "os1-64-capture", [](const fs::path& m) { fs::remove(m / "metadata.json"); }, "metadata.json"},
      {"cut metadata", "os1-64-capture", [](const fs::path& m) { write_text(m / "metadata.json", "{\n\"lidar_mode\": "); }, "metadata.json:"},
      {"no odometry", "os1-64-capture", [](const fs::path& m) { fs::remove(m / "odometry.tum"); }, "odometry.tum"},
      {"bad odometry", "os1-64-capture", [](const fs::path& m) { write_text(m / "odometry.tum", "1 0 0 0 0 0 0 1\n2 0 0 nan 0 0 0 1\n"); }, "odometry.tum:2"},
      {"bad graph", "os1-64-capture", [](const fs::path& m) { write_text(m / "pose_graph/000000_278211490950.g2o", "VERTEX_SE3:QUAT_TIME 0 0 0\n"); }, "000000_278211490950.g2o:1"},
      {"unknown node", "norlab", [](const fs::path& m) { write_text(m / "slam_pose_graph.slam", "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"); }, "slam_pose_graph.slam:1"},
      {"bad cloud", "norlab", [](const fs::path& m) { write_text(m / "individual_clouds/cloud_1690309709_285305600.pcd", "VERSION .7\nFIELDS x\n"); }, "cloud_1690309709_285305600.pcd"},
  };
  for (const Case& spoiled : cases) {
    CAPTURE(spoiled.name);
    const TemporaryFolder folder;
    const fs::path mission = copy_mission(spoiled.mission, folder.path());
    spoiled.spoil(mission);
    const ProgramResult result =
        cloister_program("replay " + mission.string() + " --out " + (folder.path() / "out").string());
    CHECK(result.exit_status == 3);
    CHECK(is_one_line(result.err));
    CHECK(result.err.find(spoiled.named) != std::string::npos);
    CHECK_FALSE(fs::exists(folder.path() / "out"));
  }
}

TEST_CASE("a graph without information matrices is refused unless a default is configured") {
  const TemporaryFolder folder;
  const fs::path mission = copy_mission("os1-64-capture", folder.path());
  write_text(mission / "pose_graph/000000_278211490950.g2o",
             "VERTEX_SE3:QUAT_TIME 0 0 0 0 0 0 0 1 278 211490950\n"
             "VERTEX_SE3:QUAT_TIME 1 1 0 0 0 0 0 1 278 311490950\n"
             "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1\n");
  const std::string arguments = "replay " + mission.string() + " --out " + (folder.path() / "out").string();
  const ProgramResult refused = cloister_program(arguments);
  CHECK(refused.exit_status == 3);
  CHECK(refused.err.find("default_information") != std::string::npos);
  CHECK(cloister_program(arguments + " --set fusion.default_information=100").exit_status == 0);
}

TEST_CASE("a capture cut off inside its last packet ends there with a warning") {
  const TemporaryFolder folder;
  const fs::path mission = copy_mission("os1-128-3scans", folder.path());
  fs::resize_file(mission / "lidar.pcap", fs::file_size(mission / "lidar.pcap") - 1000);
  const ProgramResult result =
      cloister_program("replay " + mission.string() + " --out " + (folder.path() / "out").string());
  CHECK(result.exit_status == 0);
  CHECK(result.err.find("warning") != std::string::npos);
}

TEST_CASE("an interrupt finishes the outputs and exits with 5") {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  // Real time makes the mission last long enough to be interrupted in the middle.
  const ProgramResult result =
      run_program("timeout --signal=INT 5 " + std::string(CLOISTER_PROGRAM),
                  "replay " + std::string(CLOISTER_HOUSE_MISSION) + " --realtime --out " + out.string() +
                      "; test $? -eq 124");
  CHECK(result.exit_status == 0);
  const auto summary = nlohmann::json::parse(read_text(out / "summary.json"));
  CHECK(summary["interrupted"] == true);
  CHECK(summary["scans"]["integrated"].get<int>() > 0);
  CHECK(fs::exists(out / "map.cloister"));
}

TEST_CASE("a mission in real time is integrated at its own pace") {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto start = std::chrono::steady_clock::now();
  const ProgramResult result =
      cloister_program("replay " + std::string(CLOISTER_HOUSE_MISSION) + " --realtime --out " + out.string());
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  REQUIRE(result.exit_status == 0);
  const auto summary = nlohmann::json::parse(read_text(out / "summary.json"));
  CHECK(seconds >= 14);
  // Whether the machine keeps up is measured in bench; here every scan must be accounted for.
  CHECK(summary["scans"]["read"].get<int>() ==
        summary["scans"]["integrated"].get<int>() + summary["scans"]["dropped"].get<int>());
}

TEST_CASE("query and export answer from the saved map") {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  REQUIRE(cloister_program("replay " + std::string(CLOISTER_TEST_DATA) + "/missions/os1-64-capture --out " + out.string())
              .exit_status == 0);
  const std::string map = (out / "map.cloister").string();
  const auto points = folder.path() / "points.csv";
  write_text(points, "x,y,z\n0,0,0\n500,0,0\n");
  const ProgramResult answer = cloister_program("query " + map + " " + points.string());
  CHECK(answer.exit_status == 0);
  CHECK(answer.out.rfind("x,y,z,state,log_odds,submap\n", 0) == 0);
  CHECK(answer.out.find("500,0,0,unknown,0,-1") != std::string::npos);
  write_text(points, "1,2\n");
  const ProgramResult malformed = cloister_program("query " + map + " " + points.string());
  CHECK(malformed.exit_status == 3);
  CHECK(malformed.err.find("points.csv:1") != std::string::npos);
  for (const char* suffix : {"ply", "pcd", "bt", "ot", "vdb"}) {
    const auto file = folder.path() / (std::string("map.") + suffix);
    CAPTURE(suffix);
    CHECK(cloister_program("export " + map + " --out " + file.string()).exit_status == 0);
    CHECK(fs::file_size(file) > 100);
  }
  CHECK(cloister_program("export " + map + " --out " + (folder.path() / "map.xyz").string()).exit_status == 2);
  CHECK(cloister_program("export " + points.string() + " --out " + (folder.path() / "b.ply").string()).exit_status == 3);
  CHECK(cloister_program("query " + (folder.path() / "none").string() + " " + points.string()).exit_status == 3);
}

TEST_CASE("uncertainty answers pairs of a graph, and refuses nodes that it does not have") {
  const TemporaryFolder folder;
  const std::string graph = std::string(CLOISTER_TEST_DATA) + "/uncertainty/corridor60.g2o";
  const auto pairs = folder.path() / "pairs.csv";
  write_text(pairs, "i,j\n0,57\n3,3\n");
  const ProgramResult answer = cloister_program("uncertainty " + graph + " " + pairs.string());
  CHECK(answer.exit_status == 0);
  CHECK(std::count(answer.out.begin(), answer.out.end(), '\n') == 3);
  write_text(pairs, "0,999\n");
  const ProgramResult unknown = cloister_program("uncertainty " + graph + " " + pairs.string());
  CHECK(unknown.exit_status == 3);
  CHECK(unknown.err.find("999") != std::string::npos);
}

TEST_CASE("outputs that cannot be written exit with 4") {
  const ProgramResult result = cloister_program("replay " + std::string(CLOISTER_TEST_DATA) +
                                                "/missions/os1-64-capture --out /proc/cloister-cannot-write-here");
  CHECK(result.exit_status == 4);
  CHECK(is_one_line(result.err));
}

}  // namespace
}  // namespace cloister
