#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "test/support/json.hpp"
#include "test/support/program.hpp"

namespace cloister {
namespace {

std::string map_hash(const std::string& program, const std::string& mission) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  REQUIRE(run_program(program, "replay " + mission + " --out " + out.string()).exit_status == 0);
  return read_json(out / "summary.json")["map_hash"];
}

TEST_CASE(
    "a mission becomes the same map, bit by bit, on this processor and on the one that built it") {
  const std::string data = std::string(CLOISTER_TEST_DATA) + "/missions/";
  for (const std::string& mission :
       {std::string(CLOISTER_HOUSE_MISSION), data + "os1-128-3scans", data + "os1-64-capture"}) {
    CAPTURE(mission);
    CHECK(map_hash(CLOISTER_PROGRAM, mission) == map_hash(CLOISTER_PLAIN_PROGRAM, mission));
  }
}

}  // namespace
}  // namespace cloister
