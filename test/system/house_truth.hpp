#pragma once

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "test/support/json.hpp"

namespace cloister {

/// What cloister-ground-truth says about a replay's output.
inline nlohmann::json compare_with_truth(const std::string& mission, const std::filesystem::path& out) {
  const TemporaryFolder folder;
  const auto truth_json = (folder.path() / "truth.json").string();
  const ProgramResult truth =
      run_program(CLOISTER_GROUND_TRUTH_PROGRAM, mission + " " + out.string() + " --cloister " + CLOISTER_PROGRAM +
                                                     " --points 20000 --samples 20000 --json " + truth_json);
  REQUIRE(truth.exit_status == 0);
  return read_json(truth_json);
}

/// Holds what a replay of the short house left in `out` against the world that it was simulated in.
inline void check_truth_of_house(const std::filesystem::path& out) {
  const auto figures = compare_with_truth(CLOISTER_HOUSE_MISSION, out);
  CHECK(figures["states"]["known_free_right"].get<double>() >= 0.99);
  CHECK(figures["mesh"]["within_10cm"].get<double>() >= 0.95);
}

}  // namespace cloister
