// Live missions under fault. Every case has a network of its own and really kills, stops or floods something.
#include <fcntl.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <sys/stat.h>

#include "firmware_interface/dds/roudi_probe.hpp"
#include "test/support/live_host.hpp"

namespace cloister {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

TEST_CASE(
    "RouDi absent: a mission played over UDP becomes the map of its replay, and SIGTERM saves it") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({kRoom});
  Background play = host.play({"--rate", "2"});
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  CHECK(read_text(host.log("run")) == "");
  const auto live = host.summary();
  CHECK(live["counters"]["scans_read_over_udp"] == live["scans"]["read"]);
  CHECK(host.map_loads());
  for (const char* name : {"submaps.json", "timeline.csv", "events.jsonl", "mesh.ply",
                           "report.html", "trajectory.tum"}) {
    CAPTURE(name);
    CHECK(fs::file_size(host.out() / name) > 0);
  }

  const auto replay_out = host.folder.path() / "replay";
  REQUIRE(run_program(CLOISTER_PROGRAM,
                      "replay " CLOISTER_HOUSE_MISSION " --out " + replay_out.string())
              .exit_status == 0);
  const auto recorded = read_json(replay_out / "summary.json");
  CHECK(live["scans"]["integrated"] == recorded["scans"]["integrated"]);
  CHECK(live["drops"] == recorded["drops"]);
  CHECK(live["submaps"]["final"] == recorded["submaps"]["final"]);
  CHECK(live["observed_m3"].get<double>() ==
        doctest::Approx(recorded["observed_m3"].get<double>()).epsilon(0.001));
}

TEST_CASE(
    "RouDi there, killed and restarted, publisher killed: scans go on, in shared memory or over "
    "UDP") {
  Host host;
  if (!host.is_there()) return;
  Background roudi = host.roudi();
  Background run = host.run({kRoom, "dds.shared_memory=on"});
  const std::uint64_t bytes_before = loopback_bytes();
  {
    Background play = host.play({"--rate", "2"});
    std::this_thread::sleep_for(4s);
    const std::uint64_t bytes = loopback_bytes() - bytes_before;
    play.end(SIGKILL);
    // Some 60 scans of 346 kB; discovery, odometry and graphs take less than two scans.
    CHECK(bytes < 1'000'000);
  }
  roudi.end(SIGKILL);
  {
    // Who comes now finds no daemon.
    Background play = host.play({"--start", "6", "--rate", "2"});
    std::this_thread::sleep_for(3s);
    play.end(SIGKILL);
  }
  Background second = host.roudi();
  {
    // Who comes now finds another daemon than the mapper's.
    Background play = host.play({"--start", "10", "--rate", "2"});
    CHECK(play.wait() == 0);
  }
  CHECK(run.end(SIGTERM) == 0);
  const auto summary = host.summary();
  CHECK(summary["counters"]["scans_read_in_shared_memory"].get<int>() > 10);
  CHECK(summary["counters"]["scans_read_over_udp"].get<int>() > 40);
  CHECK(summary["scans"]["integrated"].get<int>() > 60);
  CHECK(host.map_loads());
}

TEST_CASE("an instance of RouDi has one locator, whatever is written to its memory") {
  Host host;
  if (!host.is_there()) return;
  const auto locator = [] { return probe_roudi(1000, 10s).locator; };
  Background first = host.roudi();
  const std::string of_first = locator();
  CHECK(of_first != "");
  // Sets the segment's times, as the first write to a page does.
  REQUIRE(utimensat(AT_FDCWD, "/dev/shm/iceoryx_mgmt", nullptr, 0) == 0);
  CHECK(locator() == of_first);
  first.end(SIGKILL);
  Background second = host.roudi();
  CHECK(locator() != "");
  CHECK(locator() != of_first);
}

TEST_CASE("RouDi demanded but absent: the error says so, and nothing hangs") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({"dds.shared_memory=on"});
  CHECK(run.wait(20s) == 4);
  CHECK(read_text(host.log("run")).find("iox-roudi is not running") != std::string::npos);
}

TEST_CASE(
    "scans straight from the sensor's packets, odometry over DDS, SIGINT ends with outputs "
    "complete") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run(
      {kRoom, "sensor.source=udp", "sensor.metadata=" CLOISTER_HOUSE_MISSION "/metadata.json"});
  Background play = host.play({"--udp", "--rate", "2"});
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGINT) == 5);
  const auto summary = host.summary();
  CHECK(summary["interrupted"] == true);
  CHECK(summary["counters"]["lidar_packets"].get<int>() > 9000);
  CHECK(summary["scans"]["integrated"].get<int>() + summary["scans"]["dropped"].get<int>() ==
        summary["scans"]["read"].get<int>());
  CHECK(summary["scans"]["integrated"].get<int>() > 100);
  CHECK(host.map_loads());
}

TEST_CASE(
    "a scan without a pose, odometry that goes back or leaps, graphs that do not fit: each is "
    "counted, none aborts") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run();
  Robot robot;
  robot.map_first_scan();

  robot.graph(graph(1, 600, {0, 1}));
  robot.graph(graph(1, 600, {0, 1}));  // twice
  GraphUpdate unknown = graph(2, 610, {0, 1});
  unknown.graph.edges.push_back({0, 99, Pose::Identity(), Matrix6d::Identity(), true});
  robot.graph(unknown);
  GraphUpdate later = graph(9, 620, {2});
  later.base_revision = 8;
  robot.graph(later);  // builds on what never came
  GraphUpdate stranger = graph(10, 630, {0});
  stranger.session = 77;
  robot.graph(stranger);

  robot.odometry(200, 290);        // back
  robot.odometry(1010, 1010, 40);  // a leap that is none
  robot.odometry(1020, 1500);
  robot.scan(1400);
  robot.scan(5000);  // odometry stops long before
  auto values = robot.wait_for([](auto& seen) {
    return seen["scans_integrated"] == 2 && seen["drops.scan_without_pose"] == 1 &&
           seen["drops.graph_other_session"] == 1;
  });
  CHECK(values["drops.graph_repeated"] == 1);
  CHECK(values["drops.graph_edges_of_unknown_nodes"] == 1);
  CHECK(values["drops.graph_out_of_order"] == 1);
  CHECK(values["drops.odometry_backwards"] == 10);
  CHECK(values["drops.odometry_outlier"] == 1);
  CHECK(values["graph_revision"] == 2);
  CHECK(values["shared_memory"] == 0);

  // For good: nothing is mapped until the graph knows where that is.
  robot.odometry(5010, 6000, 40);
  robot.odometry(6010, 7000, 90);
  robot.scan(6500);
  robot.wait_for([](auto& seen) { return seen["drops.scan_without_node"] == 1; });
  robot.graph(graph(3, 6600, {0, 1, 2}));
  robot.scan(6700);
  robot.wait_for([](auto& seen) { return seen["scans_integrated"] == 3; });

  SubmapList list;
  for (int i = 0; i < 1000 && !robot.topics().take(list); ++i) std::this_thread::sleep_for(10ms);
  REQUIRE_FALSE(list.submaps.empty());
  CHECK(list.submaps.front().bytes > 0);
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.summary()["drops"]["scan_without_node"] == 1);
}

TEST_CASE("kill -9 loses nothing that was saved, and a new start goes on mapping") {
  Host host;
  if (!host.is_there()) return;
  {
    Background run = host.run();
    Robot robot;
    robot.map_first_scan();
    const SaveMapReply reply = robot.save_map(42);
    CHECK(reply.message == "");
    CHECK(reply.is_saved);
    CHECK(fs::path(reply.path) == host.out() / "map.cloister");
    CHECK(reply.bytes == fs::file_size(host.out() / "map.cloister"));
    CHECK(run.end(SIGKILL) == 128 + SIGKILL);
  }
  CHECK(host.map_loads());
  Background again = host.run();
  Robot robot;
  robot.odometry(2000, 3000);
  robot.scan(2500);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  CHECK(again.end(SIGTERM) == 0);
  CHECK(host.summary()["scans"]["integrated"] == 1);
}

TEST_CASE(
    "30 scans a second and more: what is too much is dropped and counted, and waits for nothing") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({"runtime.scan_queue=2"});
  Background play = host.play({"--rate", "6"});
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  const auto summary = host.summary();
  CHECK(summary["scans"]["read"].get<int>() > 0);
  CHECK(summary["scans"]["integrated"].get<int>() + summary["scans"]["dropped"].get<int>() ==
        summary["scans"]["read"].get<int>());
  int dropped = 0;
  for (const char* cause : {"scan_late", "scan_without_pose", "scan_waiting_too_many"}) {
    if (summary["drops"].contains(cause)) dropped += summary["drops"][cause].get<int>();
  }
  CHECK(dropped == summary["scans"]["dropped"].get<int>());
  CHECK(host.map_loads());
}

TEST_CASE("SIGTERM before the sensor is known ends at once") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run();
  std::this_thread::sleep_for(500ms);
  CHECK(run.end(SIGTERM) == 0);
}

}  // namespace
}  // namespace cloister
