#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/ouster/sensor_metadata.hpp"
#include "test/support/json.hpp"
#include "bench/support/private_host.hpp"
#include "test/support/program.hpp"

// For tests of live missions: they are compiled with CLOISTER_PROGRAM, CLOISTER_HOUSE_MISSION and
// CLOISTER_ROUDI_CONFIG.

namespace cloister {

constexpr std::int64_t kMs = 1'000'000;
// Enough room for a machine that is slow for a while: live cases count scans, not milliseconds.
inline const std::string kRoom = "runtime.scan_queue=160";

/// A private host with a folder for outputs, and the ways to start what a robot runs.
struct Host {
  PrivateHost host{{std::filesystem::path(CLOISTER_PROGRAM).parent_path(),
                    std::filesystem::path(CLOISTER_HOUSE_MISSION),
                    std::filesystem::path(CLOISTER_ROUDI_CONFIG).parent_path()}};
  TemporaryFolder folder;

  [[nodiscard]] bool is_there() const {
    if (host.why_not().empty()) return true;
    MESSAGE("skipped, since a network of its own is not permitted here: " << host.why_not());
    return false;
  }
  [[nodiscard]] std::filesystem::path out() const { return folder.path() / "out"; }
  [[nodiscard]] std::filesystem::path log(const std::string& name) const {
    return folder.path() / (name + ".log");
  }

  [[nodiscard]] Background run(const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> arguments = {CLOISTER_PROGRAM, "run", "--out", out().string()};
    for (const std::string& setting : settings)
      arguments.insert(arguments.end(), {"--set", setting});
    return Background(arguments, log("run"));
  }
  [[nodiscard]] Background play(const std::vector<std::string>& options = {}) const {
    std::vector<std::string> arguments = {CLOISTER_PROGRAM, "play", CLOISTER_HOUSE_MISSION};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return Background(arguments, log("play"));
  }
  /// Returns once shared memory can be used.
  [[nodiscard]] Background roudi() const {
    const std::filesystem::path log_path = log("roudi");
    std::filesystem::remove(log_path);
    Background daemon({"iox-roudi", "-m", "off", "-c", CLOISTER_ROUDI_CONFIG}, log_path);
    for (int i = 0; i < 2000 && read_text(log_path).find("ready for clients") == std::string::npos;
         ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return daemon;
  }
  [[nodiscard]] nlohmann::json summary() const { return read_json(out() / "summary.json"); }
  [[nodiscard]] bool map_loads() const {
    std::ofstream(folder.path() / "points.csv") << "0,0,0\n";
    const auto queried =
        run_program(CLOISTER_PROGRAM, "query " + (out() / "map.cloister").string() + " " +
                                          (folder.path() / "points.csv").string());
    return queried.exit_status == 0;
  }
};

/// What the mapper says about itself, once it says what is waited for.
template <typename Condition>
std::map<std::string, double> wait_for(RobotTopics& topics, Condition&& condition) {
  std::map<std::string, double> values;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < deadline) {
    if (Diagnostics diagnostics; topics.take(diagnostics)) {
      values = {diagnostics.values.begin(), diagnostics.values.end()};
      if (condition(values)) return values;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::string last;
  for (const auto& [name, value] : values) last += name + " " + std::to_string(value) + ", ";
  FAIL("the mapper did not get there: " << last);
  return values;
}

/// A scan of a round room of 3 m, without its geometry.
inline Scan round_room(int num_beams, int num_columns, std::int64_t stamp_ms) {
  Scan scan;
  scan.stamp = scan.last_packet = {stamp_ms * kMs};
  const auto columns = static_cast<std::size_t>(num_columns);
  scan.ranges_mm.assign(static_cast<std::size_t>(num_beams) * columns, 3000);
  scan.column_stamps.assign(columns, scan.stamp);
  scan.column_valid.assign(columns, 1);
  return scan;
}

/// A robot under the test's own control, with the house's sensor, that stands still in a round room.
class Robot {
 public:
  Robot() {
    auto metadata = load_metadata(std::filesystem::path(CLOISTER_HOUSE_MISSION) / "metadata.json");
    REQUIRE(metadata.has_value());
    metadata_ = *metadata;
    DdsOptions options;
    options.shared_memory = SharedMemoryUse::kOff;
    auto link = DdsLink::open(options);
    REQUIRE(link.has_value());
    link_.emplace(std::move(*link));
    auto topics = RobotTopics::open(*link_);
    REQUIRE(topics.has_value());
    topics_.emplace(std::move(*topics));
    REQUIRE(topics_->publish(SensorDescription{
        read_text(std::filesystem::path(CLOISTER_HOUSE_MISSION) / "metadata.json"),
        Pose::Identity()}));
    REQUIRE(topics_->wait_for_mapper(std::chrono::seconds(60)));
  }

  void scan(std::int64_t stamp_ms) {
    const int beams = metadata_.num_beams, columns = metadata_.num_columns;
    CHECK(topics_->publish(round_room(beams, columns, stamp_ms), beams, columns));
  }
  void odometry(std::int64_t from_ms, std::int64_t to_ms, double x_m = 0) {
    Pose T_O_B = Pose::Identity();
    T_O_B.translation().x() = x_m;
    for (std::int64_t ms = from_ms; ms <= to_ms; ms += 10) {
      CHECK(topics_->publish(OdometrySample{1, {SensorTime{ms * kMs}, T_O_B}}));
    }
  }
  void graph(const GraphUpdate& update) { CHECK(topics_->publish(update)); }
  RobotTopics& topics() { return *topics_; }
  const DdsLink& link() const { return *link_; }

  /// What the mapper says about itself, once it says what is waited for.
  template <typename Condition>
  std::map<std::string, double> wait_for(Condition&& condition) {
    return cloister::wait_for(*topics_, std::forward<Condition>(condition));
  }
  /// Odometry of a second and a scan in its middle. Returns what the mapper says once that is mapped.
  std::map<std::string, double> map_first_scan() {
    odometry(0, 1000);
    scan(500);
    return wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  }
  /// Has the map saved, and waits for the answer.
  SaveMapReply save_map(std::uint64_t id) {
    REQUIRE(topics_->publish(SaveMapRequest{id}));
    SaveMapReply reply;
    for (int i = 0; i < 6000 && !(topics_->take(reply) && reply.id == id); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    CHECK(reply.id == id);
    return reply;
  }

 private:
  SensorMetadata metadata_;
  std::optional<DdsLink> link_;
  std::optional<RobotTopics> topics_;
};

/// A whole graph of nodes that stand still.
inline GraphUpdate graph(std::uint64_t revision, std::int64_t stamp_ms,
                         const std::vector<NodeId>& ids) {
  GraphUpdate update{1, revision, 0, {SensorTime{stamp_ms * kMs}, {}, {}}};
  for (const NodeId id : ids)
    update.graph.nodes.push_back(
        {id, SensorTime{stamp_ms * kMs - 10 * kMs + id * kMs}, true, Pose::Identity()});
  return update;
}

}  // namespace cloister
