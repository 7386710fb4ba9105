#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/experiments/final_map.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

struct Options {
  std::filesystem::path mission;
  std::filesystem::path out;
  std::filesystem::path returns;
  double min_overlap = 0.7;
  ReturnSampling sampling;
};

Result<nlohmann::ordered_json> look(const Options& options) {
  const auto pairs = find_remaining_pairs(options.out / "map.cloister", options.min_overlap);
  if (!pairs) return tl::unexpected(pairs.error());
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RemainingPair& pair : *pairs) {
    list.push_back({{"a", pair.a},
                    {"b", pair.b},
                    {"root_a", pair.root_a},
                    {"root_b", pair.root_b},
                    {"overlap", pair.overlap}});
  }
  nlohmann::ordered_json answer = {{"pairs", list}};
  if (options.returns.empty()) return answer;
  const auto returns = write_placed_returns(options.mission, options.out / "trajectory.tum",
                                            options.sampling, options.returns);
  if (!returns) return tl::unexpected(returns.error());
  answer["returns"] = *returns;
  return answer;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Looks into the map that a replay left: JSON to stdout with the pairs of submaps that "
      "overlap, and the mission's returns as the replay's poses place them. A program of its own, "
      "since what judges shares no code with what is judged.",
      "cloister-bench-final-map");
  app.add_option("MISSION", options.mission, "the mission")->required();
  app.add_option("OUT", options.out, "what the replay of it left")->required();
  app.add_option("--min-overlap", options.min_overlap, "overlap from which a pair is listed")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--returns", options.returns,
                 "write returns here, float x y z in M (default: write none)");
  app.add_option("--every-scan", options.sampling.every_scan, "take each so many-th scan")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--every-pixel", options.sampling.every_pixel, "take each so many-th pixel")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto answer = look(options);
    if (!answer) return tl::unexpected(answer.error());
    std::printf("%s\n", answer->dump(2).c_str());
    return 0;
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
