#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "bench/ground_truth/state_accuracy.hpp"
#include "bench/ground_truth/truth.hpp"
#include "bench/simulate/number_text.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

struct Options {
  std::filesystem::path mission;
  std::size_t points = 100'000;
  double clearance_m = 0.10;
  std::uint64_t seed = 1;
};

Result<std::string> draw(const Options& options) {
  const auto truth = read_ground_truth(options.mission);
  if (!truth) return tl::unexpected(truth.error());
  const auto scene_W = RayScene::build(truth->mesh_W);
  if (!scene_W) return tl::unexpected(scene_W.error());
  std::string text = "x,y,z,solid\n";
  for (const TruePoint& point :
       sample_points(*truth, *scene_W, options.points, options.clearance_m, options.seed)) {
    for (int k = 0; k < 3; ++k) {
      append_number(point.p_W[k], &text);
      text += ',';
    }
    text += point.is_solid ? "1\n" : "0\n";
  }
  return text;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Draws points of a simulated world that are clear of every surface, from the part that the "
      "mission observes: "
      "x,y,z in W and 1 inside solids, to stdout. A program of its own, since what simulates "
      "shares no code with what "
      "is judged.",
      "cloister-bench-true-points");
  app.add_option("MISSION", options.mission, "the simulated mission, with its ground_truth/")
      ->required();
  app.add_option("--points", options.points, "points to draw")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  app.add_option("--clearance", options.clearance_m, "distance from every surface, metres")
      ->check(CLI::Range(0.001, 2.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "chooses the points")->capture_default_str();
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto text = draw(options);
    if (!text) return tl::unexpected(text.error());
    return std::fwrite(text->data(), 1, text->size(), stdout) == text->size() &&
                   std::fflush(stdout) == 0
               ? 0
               : static_cast<int>(ErrorKind::kResource);
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
