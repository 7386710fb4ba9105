#include <algorithm>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "bench/support/child_program.hpp"
#include "bench/experiments/json_file.hpp"
#include "bench/experiments/pair_doubt.hpp"
#include "bench/experiments/replay_figures.hpp"
#include "test/support/program.hpp"

namespace cloister {
namespace {

// Long enough for loop closures, and coarse enough to be simulated in seconds.
TEST_CASE("no two submaps of the house that overlap and are certain enough to be fused remain") {
  const TemporaryFolder folder;
  const std::filesystem::path& home = folder.path();
  const auto run = [&](const std::string& name, const std::vector<std::string>& words) {
    const auto done = run_program(words, home / (name + ".out"), home / (name + ".log"));
    if (!done) FAIL(done.error().message);
  };
  const std::string mission = (home / "mission").string();
  const std::string out = (home / "out").string();
  run("simulate", {CLOISTER_SIMULATE_PROGRAM, "house", "--out", mission, "--minutes", "1.6",
                   "--columns", "512", "--seed", "1"});
  run("replay", {CLOISTER_PROGRAM, "replay", mission, "--out", out});
  run("final_map", {CLOISTER_BENCH_FINAL_MAP_PROGRAM, mission, out});

  const auto replay = read_replay(out);
  REQUIRE(replay.has_value());
  CHECK(replay->submaps_final >= 4);
  CHECK(replay->submaps_spawned > replay->submaps_final);
  const auto final_map = JsonFile::open(home / "final_map.out");
  REQUIRE(final_map.has_value());
  const auto pairs = read_root_pairs(final_map->root());
  REQUIRE(pairs.has_value());
  const auto doubts_m =
      ask_doubts_m(CLOISTER_PROGRAM, home / "mission" / "pose_graph", home, *pairs);
  REQUIRE(doubts_m.has_value());
  CHECK(std::count_if(doubts_m->begin(), doubts_m->end(),
                      [&](double doubt_m) { return doubt_m <= replay->max_sigma_m; }) == 0);
}

}  // namespace
}  // namespace cloister
