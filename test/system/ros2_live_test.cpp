// Live missions with the topics of ROS 2. Every case has a network of its own.
#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <dds/dds.h>
#include <doctest/doctest.h>

#include "firmware_interface/dds/map_requests.hpp"
#include "firmware_interface/dds/topic_ends.hpp"
#include "firmware_interface/ouster/ouster_geometry.hpp"
#include "firmware_interface/ros2/driver_topics.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "firmware_interface/ros2/topic_qos.hpp"
#include "test/support/live_host.hpp"

namespace cloister {
namespace {

using namespace std::chrono_literals;

/// A robot with drivers of ROS 2 under the test's own control, in a round room.
class DrivenRobot {
 public:
  DrivenRobot() {
    auto metadata = load_metadata(std::filesystem::path(CLOISTER_HOUSE_MISSION) / "metadata.json");
    REQUIRE(metadata.has_value());
    geometry_ = make_geometry(*metadata);
    DdsOptions options;
    options.shared_memory = SharedMemoryUse::kOff;
    auto link = DdsLink::open(options);
    REQUIRE(link.has_value());
    link_.emplace(std::move(*link));
    auto topics = ros2::DriverTopics::open(*link_, {});
    REQUIRE(topics.has_value());
    topics_.emplace(std::move(*topics));
    auto watch = RobotTopics::open(*link_);
    REQUIRE(watch.has_value());
    watch_.emplace(std::move(*watch));
    REQUIRE(topics_->wait_for_mapper(60s));
  }

  void scan(std::int64_t stamp_ms) {
    Scan scan = round_room(geometry_.num_beams, geometry_.num_columns, stamp_ms);
    scan.geometry = &geometry_;
    CHECK(topics_->publish(scan));
  }
  void odometry(std::int64_t from_ms, std::int64_t to_ms) {
    for (std::int64_t ms = from_ms; ms <= to_ms; ms += 10)
      CHECK(topics_->publish(StampedPose{SensorTime{ms * kMs}, Pose::Identity()}));
  }
  /// Goes on until it is true, or for a minute.
  [[nodiscard]] static bool wait_until(const std::function<bool()>& is_true) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    while (!is_true()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(10ms);
    }
    return true;
  }
  const DdsLink& link() const { return *link_; }
  ros2::DriverTopics& topics() { return *topics_; }
  RobotTopics& watch() { return *watch_; }

 private:
  ScanGeometry geometry_;
  std::optional<DdsLink> link_;
  std::optional<ros2::DriverTopics> topics_;
  std::optional<RobotTopics> watch_;
};

// Clouds of three megabytes come in hundreds of datagrams: a busy machine loses some, and these cases count scans.
const std::vector<std::string> kFromDrivers = {kRoom, "sensor.source=ros2", "ros2.reliable=true",
                                               "scan.max_points=65536"};

TEST_CASE("a mission played as ROS 2's drivers would becomes the map of its replay") {
  Host host;
  if (!host.is_there()) return;
  std::vector<std::string> settings = kFromDrivers;
  // The recorded graph has covariances and is certain enough; a path has none.
  settings.push_back("fusion.fuse_without_covariance=true");
  Background run = host.run(settings);
  Background play = host.play({"--ros2"});
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  CHECK(read_text(host.log("run")).find("/path has no covariances") != std::string::npos);
  const auto live = host.summary();
  const int num_read = live["scans"]["read"].get<int>();
  CHECK(num_read > 0);
  CHECK(live["counters"]["clouds_organised"] == num_read);
  CHECK(live["scans"]["integrated"].get<int>() + live["scans"]["dropped"].get<int>() == num_read);
  CHECK(host.map_loads());

  const auto replay_out = host.folder.path() / "replay";
  REQUIRE(run_program(CLOISTER_PROGRAM,
                      "replay " CLOISTER_HOUSE_MISSION " --out " + replay_out.string())
              .exit_status == 0);
  const auto recorded = read_json(replay_out / "summary.json");
  if (live["scans"]["integrated"] != recorded["scans"]["integrated"]) {
    MESSAGE("not compared with the replay: this machine was too slow for 30 MB of clouds a second");
    return;
  }
  CHECK(live["drops"] == recorded["drops"]);
  CHECK(live["submaps"]["spawned"] == recorded["submaps"]["spawned"]);
  CHECK(live["submaps"]["final"] == recorded["submaps"]["final"]);
  CHECK(live["observed_m3"].get<double>() ==
        doctest::Approx(recorded["observed_m3"].get<double>()).epsilon(0.005));
}

TEST_CASE("a cloud waits for the static transform to its frame, and is dropped when none comes") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run(kFromDrivers);
  DrivenRobot robot;
  robot.odometry(0, 1000);
  robot.scan(500);
  wait_for(robot.watch(),
           [](auto& values) { return values["drops.scan_without_sensor_pose"] == 1; });
  CHECK(robot.topics().publish_sensor_pose(Pose::Identity()));
  robot.scan(700);
  wait_for(robot.watch(), [](auto& values) { return values["scans_integrated"] == 1; });
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.summary()["drops"]["scan_without_sensor_pose"] == 1);
}

/// A node of ROS 2 that looks at what the mapper shows.
class Viewer {
 public:
  explicit Viewer(const DdsLink& link)
      : make_(link.participant()),
        submaps_(reader<ros2::MarkerArray>("/cloister/submaps", ros2::kLatchedTopic)),
        occupied_(reader<ros2::PointCloud2>("/cloister/occupied", ros2::kLatchedTopic)),
        octomap_(reader<ros2::OctomapMessage>("/cloister/octomap", ros2::kLatchedTopic)),
        transforms_(reader<ros2::TFMessage>("/tf", ros2::kTransformsOutput)),
        diagnostics_(reader<ros2::DiagnosticArray>("/diagnostics", ros2::kDefaultTopic)),
        request_(make_.end("rt/cloister/request_octomap", ros2::descriptor<ros2::Empty>(),
                           ros2::make_qos(ros2::kDefaultTopic).get(), false)) {
    REQUIRE(make_.outcome().has_value());
  }

  /// Whether the mapper reads the request.
  bool ask_for_octomap() {
    const ros2::Empty request{};
    return wait_for_readers({&request_}, 60s) &&
           dds_write(request_.handle(), &request) == DDS_RETCODE_OK;
  }

  /// Takes what has come into plain words.
  void look() {
    take_loaned<ros2::MarkerArray>(submaps_, [&](const ros2::MarkerArray& message) {
      marker_names.clear();
      for (std::uint32_t i = 0; i < message.markers._length; ++i)
        marker_names.insert(message.markers._buffer[i].ns);
    });
    take_loaned<ros2::PointCloud2>(occupied_, [&](const ros2::PointCloud2& message) {
      cloud_frame = message.header.frame_id;
      num_points = message.width;
    });
    take_loaned<ros2::OctomapMessage>(octomap_, [&](const ros2::OctomapMessage& message) {
      octomap_bytes = message.data._length;
      CHECK(message.binary);
      CHECK(std::string(message.id) == "OcTree");
    });
    take_loaned<ros2::TFMessage>(transforms_, [&](const ros2::TFMessage& message) {
      transform = std::string(message.transforms._buffer[0].header.frame_id) + " -> " +
                  message.transforms._buffer[0].child_frame_id;
    });
    take_loaned<ros2::DiagnosticArray>(diagnostics_, [&](const ros2::DiagnosticArray& message) {
      for (std::uint32_t i = 0; i < message.status._buffer[0].values._length; ++i) {
        const auto& value = message.status._buffer[0].values._buffer[i];
        diagnostics[value.key] = value.value;
      }
    });
  }

  std::set<std::string> marker_names;
  std::string cloud_frame, transform;
  std::uint32_t num_points = 0, octomap_bytes = 0;
  std::map<std::string, std::string> diagnostics;

 private:
  template <typename Topic>
  DdsEntity reader(const char* name, const ros2::TopicQos& profile) {
    return make_.end(ros2::dds_topic_name(name), ros2::descriptor<Topic>(),
                     ros2::make_qos(profile).get(), true);
  }

  EndMaker make_;
  DdsEntity submaps_, occupied_, octomap_, transforms_, diagnostics_, request_;
};

TEST_CASE("the map is shown to ROS 2's tools, an OctoMap when they ask for it") {
  Host host;
  if (!host.is_there()) return;
  std::vector<std::string> settings = kFromDrivers;
  settings.push_back("ros2.publish=true");
  Background run = host.run(settings);
  DrivenRobot robot;
  Viewer viewer(robot.link());
  CHECK(robot.topics().publish_sensor_pose(Pose::Identity()));
  robot.odometry(0, 1000);
  for (const std::int64_t stamp_ms : {300, 500, 700}) robot.scan(stamp_ms);
  CHECK(DrivenRobot::wait_until([&] {
    viewer.look();
    return viewer.num_points > 1000 && viewer.marker_names.contains("submaps") &&
           !viewer.transform.empty() && viewer.diagnostics["scans_integrated"] == "3";
  }));
  CHECK(viewer.marker_names.contains("roots"));
  CHECK(viewer.cloud_frame == "map");
  CHECK(viewer.transform == "map -> odom");
  CHECK(viewer.diagnostics["shared_memory"] == "0");
  CHECK(viewer.octomap_bytes == 0);
  CHECK(viewer.ask_for_octomap());
  CHECK(DrivenRobot::wait_until([&] {
    viewer.look();
    return viewer.octomap_bytes > 1000;
  }));
  // Whoever comes later is shown everything again.
  Viewer latecomer(robot.link());
  CHECK(DrivenRobot::wait_until([&] {
    latecomer.look();
    return latecomer.num_points == viewer.num_points;
  }));
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.map_loads());
}

/// What a participant says of one end of a topic when it is discovered.
struct DiscoveredEnd {
  std::string type;
  bool is_reliable = false;
  bool is_latched = false;
  int depth = 0;  // which Cyclone tells, and other DDS need not

  friend bool operator==(const DiscoveredEnd&, const DiscoveredEnd&) = default;
};

/// A participant that knows nothing of the topics, and listens to who else there is.
class Listener {
 public:
  explicit Listener(const DdsLink& link)
      : publications_(dds_create_reader(link.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                        nullptr, nullptr)),
        subscriptions_(dds_create_reader(link.participant(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION,
                                         nullptr, nullptr)),
        participants_(dds_create_reader(link.participant(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT,
                                        nullptr, nullptr)) {}

  void look() {
    note(publications_, writers);
    note(subscriptions_, readers);
    while (take_loaned<dds_builtintopic_participant_t>(
        participants_, [&](const dds_builtintopic_participant_t& participant) {
          void* data = nullptr;
          std::size_t size = 0;
          if (dds_qget_userdata(participant.qos, &data, &size) && data != nullptr)
            user_data.insert(std::string(static_cast<const char*>(data), size));
          dds_free(data);
        })) {
    }
  }

  std::map<std::string, DiscoveredEnd> writers, readers;
  std::set<std::string> user_data;

 private:
  static void note(const DdsEntity& reader, std::map<std::string, DiscoveredEnd>& ends) {
    while (take_loaned<dds_builtintopic_endpoint_t>(
        reader, [&](const dds_builtintopic_endpoint_t& endpoint) {
          DiscoveredEnd end{endpoint.type_name};
          dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
          dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
          (void)dds_qget_reliability(endpoint.qos, &reliability, nullptr);
          (void)dds_qget_durability(endpoint.qos, &durability);
          end.is_reliable = reliability == DDS_RELIABILITY_RELIABLE;
          dds_history_kind_t history = DDS_HISTORY_KEEP_ALL;
          if (dds_qget_history(endpoint.qos, &history, &end.depth) &&
              history != DDS_HISTORY_KEEP_LAST)
            end.depth = 0;
          end.is_latched = durability == DDS_DURABILITY_TRANSIENT_LOCAL;
          ends[endpoint.topic_name] = end;
        })) {
    }
  }

  DdsEntity publications_, subscriptions_, participants_;
};

TEST_CASE("on the wire, topics, types, qualities of service and user data are those of ROS 2") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({"sensor.source=ros2", "ros2.publish=true"});
  Background play = host.play({"--ros2"});
  DdsOptions options;
  options.shared_memory = SharedMemoryUse::kOff;
  const auto link = DdsLink::open(options);
  REQUIRE(link.has_value());
  Listener listener(*link);
  const std::map<std::string, DiscoveredEnd> of_drivers = {
      {"rt/ouster/points", {"sensor_msgs::msg::dds_::PointCloud2_", true, false, 16}},
      {"rt/odometry", {"nav_msgs::msg::dds_::Odometry_", true, false, 512}},
      {"rt/path", {"nav_msgs::msg::dds_::Path_", true, false, 10}},
      {"rt/tf_static", {"tf2_msgs::msg::dds_::TFMessage_", true, true, 100}}};
  const std::map<std::string, DiscoveredEnd> of_mapper = {
      {"rt/cloister/submaps", {"visualization_msgs::msg::dds_::MarkerArray_", true, true, 1}},
      {"rt/cloister/occupied", {"sensor_msgs::msg::dds_::PointCloud2_", true, true, 1}},
      {"rt/cloister/octomap", {"octomap_msgs::msg::dds_::Octomap_", true, true, 1}},
      {"rt/tf", {"tf2_msgs::msg::dds_::TFMessage_", true, false, 100}},
      {"rt/diagnostics", {"diagnostic_msgs::msg::dds_::DiagnosticArray_", true, false, 10}}};
  const std::map<std::string, DiscoveredEnd> read = {
      {"rt/ouster/points", {"sensor_msgs::msg::dds_::PointCloud2_", false, false, 16}},
      {"rt/odometry", {"nav_msgs::msg::dds_::Odometry_", false, false, 512}},
      {"rt/path", {"nav_msgs::msg::dds_::Path_", true, false, 10}},
      {"rt/tf_static", {"tf2_msgs::msg::dds_::TFMessage_", true, true, 100}},
      {"rt/cloister/request_octomap", {"std_msgs::msg::dds_::Empty_", false, false, 5}}};
  const auto all_in = [](const auto& expected, const auto& seen) {
    for (const auto& [topic, end] : expected) {
      if (!seen.contains(topic)) return false;
    }
    return true;
  };
  CHECK(DrivenRobot::wait_until([&] {
    listener.look();
    return all_in(of_drivers, listener.writers) && all_in(of_mapper, listener.writers) &&
           all_in(read, listener.readers);
  }));
  const auto check = [](const auto& expected, auto& seen) {
    for (const auto& [topic, end] : expected) {
      CAPTURE(topic);
      CHECK(seen[topic].type == end.type);
      CHECK(seen[topic].is_reliable == end.is_reliable);
      CHECK(seen[topic].is_latched == end.is_latched);
      CHECK(seen[topic].depth == end.depth);
    }
  };
  check(of_drivers, listener.writers);
  check(of_mapper, listener.writers);
  check(read, listener.readers);
  CHECK(listener.user_data == std::set<std::string>{"enclave=/;"});
  play.end(SIGKILL);
  CHECK(run.end(SIGTERM) == 0);
}

TEST_CASE("a source that is none, and a mission of ROS 2 without topics, are refused by name") {
  const auto refused = [](const std::string& settings) {
    const TemporaryFolder folder;
    const ProgramResult result =
        run_program(CLOISTER_PROGRAM, "run --out " + folder.path().string() + "/out " + settings);
    CHECK(result.exit_status == 2);
    return result.err;
  };
  CHECK(refused("--set sensor.source=rosx").find("must be dds, udp or ros2") != std::string::npos);
  CHECK(refused("--set sensor.source=ros2 --set ros2.odometry_topic= --set ros2.path_topic= "
                "--set dds.shared_memory=off")
            .find("must be named") != std::string::npos);
}

}  // namespace
}  // namespace cloister
