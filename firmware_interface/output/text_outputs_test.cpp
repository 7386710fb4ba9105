#include <cstdlib>
#include <sstream>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "firmware_interface/output/events_jsonl.hpp"
#include "firmware_interface/output/submaps_json.hpp"
#include "firmware_interface/output/summary_json.hpp"
#include "firmware_interface/output/test_mission.hpp"
#include "firmware_interface/output/timeline_csv.hpp"
#include "firmware_interface/output/trajectory_tum.hpp"

namespace cloister {
namespace {

using Json = nlohmann::json;

Json parse(const std::string& text) { return Json::parse(text, nullptr, false); }

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> split(const std::string& line, char separator) {
  std::istringstream stream(line);
  std::vector<std::string> cells;
  for (std::string cell; std::getline(stream, cell, separator);) cells.push_back(cell);
  return cells;
}

TEST_CASE("summary.json has every documented key with the record's values") {
  const MissionRecord r = make_test_mission();
  const Json json = parse(summary_json(r));
  REQUIRE(json.is_object());
  CHECK(json.at("voxel_size_m") == 0.065);
  CHECK(json.at("min_range_m") == 0.5);
  CHECK(json.at("max_range_m") == 60.0);
  CHECK(json.at("scans") == Json{{"read", 503}, {"integrated", 500}, {"dropped", 3}});
  CHECK(json.at("returns_integrated") == 24'123'456);
  CHECK(json.at("duration_s") == r.duration_s);
  CHECK(json.at("travel_m") == r.travel_m);
  CHECK(json.at("submaps") == Json{{"spawned", 8}, {"fused", 2}, {"final", 6}, {"peak", 7}});
  CHECK(json.at("observed_m3") == 468.25);
  CHECK(json.at("fusions") == Json{{"proposed_by_loop", 3},
                                   {"proposed_by_overlap", 5},
                                   {"accepted", 2},
                                   {"rejected_by_uncertainty", 1},
                                   {"rejected_by_overlap", 5}});
  const Json& memory = json.at("memory");
  CHECK(memory.at("budget_bytes") == 64'000'000);
  CHECK(memory.at("map_bytes_peak") == 19'900'000);
  CHECK(memory.at("map_bytes_final") == 17'400'000);
  CHECK(memory.at("spilled_bytes") == 7'000);
  CHECK(memory.at("rss_peak_bytes") == 181'000'000);
  for (const char* stage : {"integrate", "latency", "overlap", "fuse", "uncertainty"}) {
    CAPTURE(stage);
    const Json& timing = json.at("timing_ms").at(stage);
    CHECK(timing.size() == 4);
    CHECK(timing.at("p50") <= timing.at("p95"));
    CHECK(timing.at("p95") <= timing.at("p99"));
    CHECK(timing.at("p99") <= timing.at("max"));
    CHECK(timing.at("p50") > 0);
  }
  CHECK(json.at("timing_ms").at("fuse").at("max") == 55.5);
  const Json& integration_cpu = json.at("timing_ms").at("integration_cpu");
  CHECK(integration_cpu.at("p99") <= integration_cpu.at("p999"));
  CHECK(integration_cpu.at("p999") <= integration_cpu.at("max"));
  CHECK(integration_cpu.at("max") < json.at("timing_ms").at("integrate").at("max"));
  CHECK(integration_cpu.at("p50") > 0);
  const Json& cpu = json.at("cpu_s");
  CHECK(cpu.size() == 7);
  CHECK(cpu.at("decode") == 1.25);
  CHECK(cpu.at("spawn_check") == 0.9);
  CHECK(cpu.at("integration") == 12.1);
  CHECK(cpu.at("overlap") == 0.01);
  CHECK(cpu.at("uncertainty") == 0.002);
  CHECK(cpu.at("fusion") == 0.1);
  CHECK(cpu.at("total") == 15.3);
  CHECK(json.at("drops") == Json{{"no_pose", 2}, {"queue_full", 1}});
  CHECK(json.at("map_hash") == "0x00abcdef01234567");
  CHECK(json.at("config").at("fusion").at("max_sigma_m") == 0.2);
}

TEST_CASE("the summary of an empty mission has the same keys") {
  const Json full = parse(summary_json(make_test_mission()));
  const Json empty = parse(summary_json(MissionRecord{}));
  REQUIRE(empty.is_object());
  for (const auto& [key, value] : full.items()) {
    CAPTURE(key);
    REQUIRE(empty.contains(key));
    CHECK(empty.at(key).type_name() == std::string(value.type_name()));
  }
  CHECK(empty.at("drops").empty());
}

TEST_CASE("a number that is not finite becomes null, and bytes that are not UTF-8 do no harm") {
  MissionRecord r;
  r.travel_m = std::nan("");
  r.duration_s = std::numeric_limits<double>::infinity();
  r.mission = "caf\xE9";
  r.warnings = {"\xFF\xFE"};
  const Json json = parse(summary_json(r));
  REQUIRE(json.is_object());
  CHECK(json.at("travel_m").is_null());
  CHECK(json.at("duration_s").is_null());
}

TEST_CASE("submaps.json reads back to the same doubles") {
  const MissionRecord r = make_test_mission();
  const Json json = parse(submaps_json(r.submaps));
  REQUIRE(json.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    const SubmapRecord& submap = r.submaps[i];
    const Eigen::Quaterniond q(submap.T_M_S.linear());
    const Json& read = json[i];
    CHECK(read.at("id") == submap.id);
    CHECK(read.at("merged_from") == submap.merged_from);
    CHECK(read.at("root_node") == submap.root);
    REQUIRE(read.at("T_M_S").size() == 7);
    CHECK(read.at("T_M_S")[0] == submap.T_M_S.translation().x());
    CHECK(read.at("T_M_S")[5] == q.z());
    CHECK(read.at("T_M_S")[6] == q.w());
    CHECK(read.at("aabb_M").at("min") ==
          std::vector<double>{submap.aabb_min_M.x(), 0.0, submap.aabb_min_M.z()});
    CHECK(read.at("aabb_M").at("max")[1] == 6.0);
    CHECK(read.at("nodes") == submap.nodes);
    CHECK(read.at("scan_stamps_ns").size() == 80);
    CHECK(read.at("scan_stamps_ns")[0] == submap.scan_stamps[0].ns);
    CHECK(read.at("blocks") == submap.blocks);
    CHECK(read.at("bytes") == submap.bytes);
  }
  CHECK(parse(submaps_json({})) == Json::array());
}

TEST_CASE(
    "timeline.csv has the documented header and a row a scan that reads back to the same floats") {
  const MissionRecord r = make_test_mission();
  const std::vector<std::string> lines = lines_of(timeline_csv(r.timeline));
  REQUIRE(lines.size() == 501);
  CHECK(lines[0] ==
        "stamp_ns,submap,integrate_ms,latency_ms,submaps,map_bytes,queue_depth,overlap_ratio");
  for (std::size_t i = 0; i < r.timeline.size(); ++i) {
    const TimelineRow& row = r.timeline[i];
    const std::vector<std::string> cells = split(lines[i + 1], ',');
    REQUIRE(cells.size() == 8);
    CHECK(std::atoll(cells[0].c_str()) == row.stamp.ns);
    CHECK(std::atoi(cells[1].c_str()) == row.submap);
    CHECK(std::strtof(cells[2].c_str(), nullptr) == row.integrate_ms);
    CHECK(std::strtof(cells[3].c_str(), nullptr) == row.latency_ms);
    CHECK(std::atoi(cells[4].c_str()) == row.submaps);
    CHECK(std::atoll(cells[5].c_str()) == row.map_bytes);
    CHECK(std::atoi(cells[6].c_str()) == row.queue_depth);
    CHECK(std::strtof(cells[7].c_str(), nullptr) == row.overlap_ratio);
  }
}

TEST_CASE("trajectory.tum has exact stamps and poses that read back to the same doubles") {
  const MissionRecord r = make_test_mission();
  const std::vector<std::string> lines = lines_of(trajectory_tum(r.path_M));
  REQUIRE(lines.size() == 501);
  CHECK(lines[0].front() == '#');
  CHECK(lines[1].substr(0, 21) == "1650000000.123456789 ");
  for (std::size_t i = 0; i < r.path_M.size(); ++i) {
    const std::vector<std::string> cells = split(lines[i + 1], ' ');
    REQUIRE(cells.size() == 8);
    const Eigen::Vector3d t_M_L = r.path_M[i].second.translation();
    for (int axis = 0; axis < 3; ++axis)
      CHECK(std::strtod(cells[1 + axis].c_str(), nullptr) == t_M_L[axis]);
    const Eigen::Quaterniond q(r.path_M[i].second.linear());
    CHECK(std::strtod(cells[7].c_str(), nullptr) == q.w());
  }
}

TEST_CASE("every line of events.jsonl is an object with a stamp and a documented name") {
  const MissionRecord r = make_test_mission();
  const std::vector<std::string> lines = lines_of(events_jsonl(r.events));
  REQUIRE(lines.size() == r.events.size());
  std::map<std::string, Json> last_of_kind;
  for (const std::string& line : lines) {
    const Json json = parse(line);
    REQUIRE(json.is_object());
    CHECK(json.at("stamp_ns").is_number_integer());
    last_of_kind[json.at("event")] = json;
  }
  for (const char* name :
       {"spawn", "loop_closure", "overlap_checked", "fusion_accepted", "fusion_rejected",
        "graph_updated", "spill", "reload", "degrade", "drop"}) {
    CAPTURE(name);
    CHECK(last_of_kind.contains(name));
  }
  CHECK(last_of_kind.at("spawn").at("submap") == 7);
  CHECK(last_of_kind.at("spawn").at("overlap_ratio") == 0.55 - 0.01 * 7);
  CHECK(last_of_kind.at("spawn").at("root_node") == 70);
  CHECK_FALSE(last_of_kind.at("spawn").contains("b"));
  CHECK(last_of_kind.at("loop_closure").at("node_a") == 21);
  CHECK(last_of_kind.at("loop_closure").at("b") == 7);
  CHECK(last_of_kind.at("graph_updated").at("nodes") == 71);
  const Json& accepted = last_of_kind.at("fusion_accepted");
  CHECK(accepted.at("a") == 2);
  CHECK(accepted.at("b") == 7);
  CHECK(accepted.at("ratio_a") == 0.81);
  CHECK(accepted.at("ratio_b") == 0.1 + 0.2);
  CHECK(accepted.at("sigma_m") == std::vector<double>{0.011, 0.012, 0.031});
  CHECK(accepted.at("root_a") == 20);
  CHECK(accepted.at("root_b") == 70);
  CHECK(accepted.at("shift_m") == 0.08);
  CHECK(accepted.at("reason") == "loop");
}

TEST_CASE("a check without an uncertainty still carries its keys, as null") {
  const MissionRecord r = make_test_mission();
  for (const std::string& line : lines_of(events_jsonl(r.events))) {
    const Json json = parse(line);
    if (json.at("event") != "overlap_checked" || json.at("a") != 3) continue;
    CHECK(json.at("ratio_a").is_null());
    CHECK(json.at("ratio_b") == 0.02);
    CHECK(json.at("sigma_m") == Json{nullptr, nullptr, nullptr});
  }
}

}  // namespace
}  // namespace cloister
