#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "bench/integration/sequence_bench.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

struct CommandLine {
  SequenceOptions sequence;
  std::filesystem::path out;
  std::filesystem::path scans_out;
  std::string commit = CLOISTER_COMMIT;
  double budget_mb = 1024;
};

void declare(CommandLine& line, CLI::App& app) {
  SequenceOptions& s = line.sequence;
  VoxelConfig& voxel = s.config.voxel;
  const std::map<std::string, PoseSource> sources = {{"auto", PoseSource::kAuto},
                                                     {"odometry", PoseSource::kOdometry},
                                                     {"truth", PoseSource::kTruth}};
  app.add_option("MISSION", s.mission, "the mission whose scans are integrated")->required();
  app.add_option("--scans", s.scans, "scans to read (default: all)")->check(CLI::NonNegativeNumber);
  app.add_option("--skip", s.skip, "scans to pass over first")->check(CLI::NonNegativeNumber);
  app.add_option("--hold-out", s.hold_out, "every so many-th scan is kept for judging; 0 = none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--beam-stride", s.beam_stride, "every so many-th pixel of those is judged")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--poses", s.poses, "auto (the truth where there is one), odometry or truth")
      ->transform(CLI::CheckedTransformer(sources));
  app.add_option("--octomap-scans", s.octomap_scans,
                 "scans to read for the comparison with OctoMap; 0 = none (default: as many as fit "
                 "into --octomap-seconds)");
  app.add_option("--octomap-seconds", s.octomap_s, "CPU time for OctoMap")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--warm-up", s.warm_up, "scans before page faults and allocations count")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--truth-points", s.truth_points, "points compared with the truth; 0 = none")
      ->capture_default_str();
  app.add_option("--budget-mb", line.budget_mb, "memory of the pools")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--voxel", voxel.voxel_size_m, "edge of a voxel, metres")->capture_default_str();
  app.add_option("--min-range", voxel.min_range_m, "metres")->capture_default_str();
  app.add_option("--max-range", voxel.max_range_m, "metres")->capture_default_str();
  app.add_option("--out", line.out, "append the results to this CSV");
  app.add_option("--scans-csv", line.scans_out, "write the cost of every scan to this CSV");
  app.add_option("--commit", line.commit, "what is measured")->capture_default_str();
}

void print(const SequenceResults& all, const std::vector<std::vector<Cell>>& rows) {
  print_table(rows);
  std::printf("\nmemory of cloister's map by type\n");
  for (const ByteShare& share : all.byte_shares) {
    std::printf("  %-28s %10zu x %6zu bytes = %12zu\n", share.type.c_str(), share.count,
                share.bytes_each, share.count * share.bytes_each);
  }
  if (all.num_declined > 0) {
    std::printf("%zu updates were declined by full pools: give more --budget-mb\n",
                all.num_declined);
  }
  if (all.context.cycle_kind == CycleKind::kNone) {
    std::printf("cycles: not counted, the system offers no hardware counters to this program\n");
  }
  const auto octomap =
      std::find_if(all.results.begin(), all.results.end(),
                   [](const BenchResult& result) { return result.library == "octomap"; });
  if (octomap != all.results.end()) {
    std::printf("OctoMap integrated the first %zu scans\n", octomap->costs.size());
  }
}

Result<void> bench(CommandLine& line) {
  Config& config = line.sequence.config;
  config.memory.budget_bytes = static_cast<std::int64_t>(line.budget_mb * 1024 * 1024);
  if (const auto wrong = validate(config)) return fail(ErrorKind::kUsage, *wrong);
  auto all = run_sequence(line.sequence);
  if (!all) return tl::unexpected(all.error());
  all->context.commit = line.commit;
  std::vector<std::vector<Cell>> rows;
  for (const BenchResult& result : all->results) rows.push_back(cells_of(all->context, result));
  print(*all, rows);
  if (!line.scans_out.empty()) {
    if (auto written = write_scans_csv(line.scans_out, all->results); !written) return written;
  }
  return line.out.empty() ? Result<void>{} : append_csv(line.out, rows);
}

int run(int argc, char** argv) {
  CommandLine line;
  CLI::App app(
      "Integrates the scans of a mission into one volume, in one thread, and says what a scan "
      "costs, what the map "
      "weighs and how it agrees with scans held out and with the simulated truth; the same for "
      "OctoMap on the first "
      "scans.",
      "cloister-bench-integration");
  declare(line, app);
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto done = bench(line);
    if (!done) return tl::unexpected(done.error());
    return 0;
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
