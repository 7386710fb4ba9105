#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>

#include "bench/support/child_program.hpp"
#include "bench/experiments/experiment.hpp"
#include "bench/experiments/growth_plot.hpp"
#include "bench/experiments/limits.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

constexpr double kQuickCampusMinutes = 4.0;

struct Options {
  ExperimentOptions experiment;
  std::vector<std::string> worlds = {"small-rooms", "large-rooms", "three-storey", "campus"};
  std::vector<std::uint64_t> seeds = {1, 2, 3};
  fs::path results;
  bool quick = false;
};

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// What stands behind a key of /proc/cpuinfo, with the number of cores.
std::string describe_machine() {
  const std::string text = read_text("/proc/cpuinfo");
  const std::size_t at = text.find(": ", text.find("model name"));
  const std::string model =
      at == std::string::npos ? "unknown" : text.substr(at + 2, text.find('\n', at) - at - 2);
  return model + "; " + std::to_string(std::thread::hardware_concurrency()) + " cores";
}

Provenance describe(const Options& options) {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  char date[32] = "";
  if (gmtime_r(&now, &utc) != nullptr) std::strftime(date, sizeof(date), "%Y-%m-%d", &utc);
  return {date, describe_machine(), source_commit(CLOISTER_TREE, options.experiment.out)};
}

Result<void> write_text(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (stream) return {};
  return fail(ErrorKind::kResource, file.string() + ": cannot be written: check the path");
}

/// The table of everything so far and this experiment's plots; those of a world's first seed stand for it.
Result<void> write_results(const Options& options, const std::vector<Experiment>& experiments,
                           const Provenance& provenance) {
  const std::string csv = format_csv(experiments, provenance);
  const std::string plot = growth_plot_svg(experiments.back());
  const Experiment& e = experiments.back();
  const std::string name = experiment_name(e);
  if (const auto done = write_text(options.experiment.out / "experiments.csv", csv); !done)
    return done;
  if (const auto done = write_text(options.experiment.out / (name + "_memory.svg"), plot); !done)
    return done;
  if (options.results.empty()) return {};
  std::error_code error;
  fs::create_directories(options.results, error);
  if (const auto done = write_text(options.results / "experiments.csv", csv); !done) return done;
  if (e.seed != options.seeds.front() || e.fault != GraphFault::kNone || e.clouds) return {};
  // Rooms coloured by submap, storey by storey, as the replay drew them.
  const std::string plan = read_text(options.experiment.out / name / "ours" / "plan.svg");
  if (!plan.empty()) {
    if (const auto done = write_text(options.results / (e.world + "_plan.svg"), plan); !done)
      return done;
  }
  return write_text(options.results / (e.world + "_memory.svg"), plot);
}

Result<void> run_all(const Options& options) {
  std::error_code error;
  fs::create_directories(options.experiment.out, error);
  if (error) {
    return fail(ErrorKind::kResource,
                options.experiment.out.string() + ": cannot be made: " + error.message());
  }
  const auto begin = std::chrono::steady_clock::now();
  const Provenance provenance = describe(options);
  std::printf("%s, %s, commit %s\n\n", provenance.date.c_str(), provenance.machine.c_str(),
              provenance.commit.c_str());
  std::vector<Experiment> experiments;
  std::vector<std::string> failures;
  Result<void> result;
  for (const std::string& world : options.worlds) {
    for (const std::uint64_t seed : options.seeds) {
      ExperimentOptions each = options.experiment;
      if (options.quick && world == "campus" && !(each.minutes > 0.0))
        each.minutes = kQuickCampusMinutes;
      auto experiment = run_experiment(each, world, seed);
      if (!experiment) {
        // Hours of other experiments are worth having; the first failure is the command's own.
        std::fprintf(stderr, "%s_%llu: %s\n", world.c_str(), static_cast<unsigned long long>(seed),
                     experiment.error().message.c_str());
        if (result) result = tl::unexpected(experiment.error());
        if (experiment.error().kind == ErrorKind::kInterrupted) return result;
        continue;
      }
      const auto lines = judge_lines(*experiment);
      std::printf("%s\n", format_table(*experiment, lines).c_str());
      std::fflush(stdout);
      for (const Line& line : lines) {
        if (!line.verdict.starts_with("FAIL")) continue;
        failures.push_back(line.verdict + " " + experiment_name(*experiment) + ": " +
                           line.what + " " + line.ours + ", limit " + line.limit);
      }
      experiments.push_back(std::move(*experiment));
      if (const auto done = write_results(options, experiments, provenance); !done) return done;
    }
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("%zu experiments in %.1f minutes, %zu limits missed\n", experiments.size(),
              took.count() / 60.0, failures.size());
  for (const std::string& failure : failures) std::printf("  %s\n", failure.c_str());
  return result;
}

int run(int argc, char** argv) {
  Options options;
  options.experiment.programs = program_folder();
  CLI::App app(
      "Simulates every world, maps it, maps it again as a baseline, and holds what comes out "
      "against its limits: tables to stdout, OUT/experiments.csv and plots. Limits that are missed "
      "are a result, not an error.",
      "cloister-experiments");
  app.add_option("--out", options.experiment.out, "directory for missions, maps and tables")
      ->required();
  const std::set<std::string> known(options.worlds.begin(), options.worlds.end());
  app.add_option("--world", options.worlds, "only these worlds (default: all four)")
      ->check(CLI::IsMember(known));
  auto* seeds = app.add_option("--seeds", options.seeds, "one mission for each (default: 1,2,3)")
                    ->delimiter(',');
  app.add_option("--graph-fault", options.experiment.fault,
                 "none; doubted-closures or wrong-closures (one loop closure in twenty, admitting "
                 "its doubt or not); late-shift (old nodes move by a metre, late)")
      ->transform(CLI::CheckedTransformer(graph_fault_names()));
  app.add_option("--clouds", options.experiment.clouds,
                 "missions of one cloud a graph node and no odometry, not of packets: scans (the last revolution) or "
                 "gathered (every fourth beam and column since the node before)")
      ->transform(CLI::CheckedTransformer(cloud_kind_names()));
  app.add_option("--minutes", options.experiment.minutes,
                 "end missions there (default: at the end of their paths)")
      ->check(CLI::PositiveNumber);
  app.add_flag("--quick", options.quick, "one seed, and the first four minutes of the campus");
  app.add_flag("--keep", options.experiment.keep,
               "keep the missions' packets or clouds, gigabytes each, and use those that are there already "
               "(of whatever length they are)");
  app.add_option("--results", options.results,
                 "also write experiments.csv, WORLD_memory.svg and WORLD_plan.svg here");
  app.add_option("--programs", options.experiment.programs,
                 "folder of the other programs (default: beside this one)");
  return run_program(app, argc, argv, [&]() -> Result<int> {
    if (options.quick && seeds->count() == 0) options.seeds.resize(1);
    const auto done = run_all(options);
    if (!done) return tl::unexpected(done.error());
    return 0;
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
