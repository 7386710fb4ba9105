#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "test/support/json.hpp"
#include "test/support/program.hpp"
#include "test/system/house_truth.hpp"

namespace cloister {
namespace {

ProgramResult replay(const std::string& mission, const std::filesystem::path& out,
                     const std::string& options = "") {
  return run_program(CLOISTER_PROGRAM,
                     "replay " + mission + " --out " + out.string() + " " + options);
}

const std::string kData = std::string(CLOISTER_TEST_DATA) + "/missions/";

TEST_CASE("a replay of the house leaves every output, true to the world it was simulated in") {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const ProgramResult result = replay(CLOISTER_HOUSE_MISSION, out);
  CHECK(result.err == "");
  REQUIRE(result.exit_status == 0);
  for (const char* name :
       {"summary.json", "submaps.json", "timeline.csv", "events.jsonl", "mesh.ply", "map.cloister",
        "report.html", "trajectory.tum", "submaps/0.ply"}) {
    CAPTURE(name);
    CHECK(std::filesystem::file_size(out / name) > 0);
  }
  const auto summary = read_json(out / "summary.json");
  CHECK(summary["scans"]["read"] == summary["scans"]["integrated"]);
  CHECK(summary["scans"]["dropped"] == 0);
  CHECK(summary["scans"]["read"].get<int>() > 140);
  CHECK(summary["submaps"]["final"].get<int>() >= 2);
  CHECK(summary["memory"]["map_bytes_final"].get<double>() > 1e5);

  check_truth_of_house(out);
}

TEST_CASE("the map does not depend on the vectors that the processor has" *
          doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  std::string first_hash;
  for (const char* bits : {"0", "256", "128", "64"}) {
    CAPTURE(bits);
    const auto out = folder.path() / bits;
    REQUIRE(replay(CLOISTER_HOUSE_MISSION, out, std::string("--set runtime.vector_bits=") + bits)
                .exit_status == 0);
    const std::string hash = read_json(out / "summary.json")["map_hash"];
    if (first_hash.empty()) first_hash = hash;
    CHECK(hash == first_hash);
  }
}

TEST_CASE("the map depends neither on the numbers of workers nor on the run" *
          doctest::test_suite("slow_threads")) {
  const TemporaryFolder folder;
  std::string first_hash;
  int run = 0;
  // A high spawn threshold makes many submaps and many fusions.
  for (const char* workers :
       {"runtime.overlap_workers=1", "runtime.overlap_workers=1", "runtime.overlap_workers=4",
        "runtime.integration_workers=2", "runtime.integration_workers=3"}) {
    CAPTURE(workers);
    const auto out = folder.path() / std::to_string(run++);
    const ProgramResult result = replay(
        CLOISTER_HOUSE_MISSION, out, std::string("--set spawn.min_overlap=0.85 --set ") + workers);
    REQUIRE(result.exit_status == 0);
    const auto summary = read_json(out / "summary.json");
    CHECK(summary["fusions"]["accepted"].get<int>() > 0);
    const std::string hash = summary["map_hash"];
    if (first_hash.empty()) first_hash = hash;
    CHECK(hash == first_hash);
  }
}

TEST_CASE("a full budget declines updates, says so, and loses nothing that is mapped") {
  const TemporaryFolder folder;
  const ProgramResult result = replay(CLOISTER_HOUSE_MISSION, folder.path() / "out",
                                      "--set memory.budget_bytes=33554432 --set "
                                      "memory.max_submaps=1000 --set voxel.voxel_size_m=0.02");
  REQUIRE(result.exit_status == 0);
  const auto summary = read_json(folder.path() / "out/summary.json");
  CHECK(summary["scans"]["dropped"] == 0);
  CHECK(summary["drops"]["voxel_updates_memory_full"].get<std::int64_t>() > 0);
  CHECK(summary["memory"]["map_bytes_peak"].get<std::int64_t>() <= 33554432);
}

TEST_CASE("the baseline spawns by distance") {
  const TemporaryFolder folder;
  const ProgramResult result = replay(CLOISTER_HOUSE_MISSION, folder.path() / "out",
                                      "--baseline --set spawn.baseline_distance_m=2");
  REQUIRE(result.exit_status == 0);
  const auto summary = read_json(folder.path() / "out/summary.json");
  const double travel_m = summary["travel_m"];
  CHECK(summary["submaps"]["spawned"].get<double>() == doctest::Approx(travel_m / 2).epsilon(0.3));
}

TEST_CASE("a captured OS1-64 frame replays with all its returns") {
  const TemporaryFolder folder;
  const ProgramResult result = replay(kData + "os1-64-capture", folder.path() / "out");
  CHECK(result.err == "");
  REQUIRE(result.exit_status == 0);
  const auto summary = read_json(folder.path() / "out/summary.json");
  CHECK(summary["scans"]["integrated"] == 1);
  CHECK(summary["counters"]["returns_read"] == 16749);
}

TEST_CASE("three captured OS1-128 frames on a moving platform replay with all their returns") {
  const TemporaryFolder folder;
  const ProgramResult result = replay(kData + "os1-128-3scans", folder.path() / "out");
  REQUIRE(result.exit_status == 0);
  const auto summary = read_json(folder.path() / "out/summary.json");
  CHECK(summary["scans"]["integrated"] == 3);
  CHECK(summary["counters"]["returns_read"] == 107647 + 107357 + 107532);
  CHECK(summary["drops"].empty());
}

TEST_CASE("clouds with a graph and nothing else replay one cloud a node" *
          doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  const ProgramResult result = replay(kData + "norlab", folder.path() / "out");
  REQUIRE(result.exit_status == 0);
  const auto summary = read_json(folder.path() / "out/summary.json");
  CHECK(summary["scans"]["integrated"] == 14);
  const auto submaps = read_json(folder.path() / "out/submaps.json");
  REQUIRE(submaps.size() == 1);
  CHECK(submaps[0]["nodes"].size() == 14);
}

TEST_CASE("a house of which only clouds and a graph are known comes out room by room" * doctest::test_suite("slow")) {
  for (const auto& [kind, least_rand_index] : {std::pair{"scans", 0.9}, {"gathered", 0.7}}) {
    CAPTURE(kind);
    const TemporaryFolder folder;
    const std::string mission = (folder.path() / "mission").string();
    REQUIRE(run_program(CLOISTER_SIMULATE_PROGRAM,
                        "house --seed 5 --columns 512 --out " + mission + " --clouds " + kind)
                .exit_status == 0);
    const auto out = folder.path() / "out";
    REQUIRE(replay(mission, out).exit_status == 0);
    const auto summary = read_json(out / "summary.json");
    CHECK(summary["scans"]["integrated"].get<int>() > 60);
    CHECK(summary["drops"].empty());
    const auto figures = compare_with_truth(mission, out);
    CHECK(figures["rooms"]["adjusted_rand_index"].get<double>() >= least_rand_index);
    CHECK(figures["mesh"]["within_10cm"].get<double>() >= 0.95);
  }
}

}  // namespace
}  // namespace cloister
