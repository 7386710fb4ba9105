#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "bench/experiments/json_file.hpp"
#include "bench/integration/bench_result.hpp"
#include "bench/live/live_run.hpp"
#include "bench/live/map_difference.hpp"
#include "bench/support/child_program.hpp"
#include "bench/support/private_host.hpp"
#include "bench/support/program.hpp"
#include "firmware_interface/map/map_file.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

// Exit status where a network of its own is not permitted: automake's for a test that was skipped.
constexpr int kSkipped = 77;

struct CommandLine {
  std::string world = "large-rooms";
  double minutes = 10;
  std::vector<std::string> transports = {"shared-memory", "udp", "packets"};
  LiveOptions live;
  fs::path out;
  fs::path results;
  bool from_memory = false;
};

/// What the same mission becomes in lockstep.
struct Replay {
  std::int64_t scans = 0;
  LoadedMap map;
};

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

/// "3 scan_late; 1 graph_repeated"
std::string list_of(const std::map<std::string, std::int64_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts)
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " " + name;
  return text.empty() ? "none" : text;
}

/// Threads by their CPU time, those of less than a hundredth of a second left out.
std::string list_of(const std::map<std::string, double>& cpu_s) {
  std::multimap<double, std::string, std::greater<>> sorted;
  for (const auto& [name, seconds] : cpu_s) sorted.emplace(seconds, name);
  std::string text;
  for (const auto& [seconds, name] : sorted) {
    if (seconds >= 0.01) text += (text.empty() ? "" : "; ") + name + " " + number(seconds, 2);
  }
  return text;
}

Result<Replay> replay(const CommandLine& line) {
  const fs::path out = line.out / "replay";
  std::vector<std::string> words = {(line.live.programs / "cloister").string(), "replay",
                                    line.live.mission.string(), "--out", out.string()};
  for (const std::string& setting : line.live.settings)
    words.insert(words.end(), {"--set", setting});
  const auto done = run_program(words, line.out / "replay.out", line.out / "replay.log");
  if (!done) return tl::unexpected(done.error());
  auto summary = JsonFile::open(out / "summary.json");
  if (!summary) return tl::unexpected(summary.error());
  Replay result;
  result.scans = summary->number<std::int64_t>("/scans/read");
  if (const auto whole = summary->is_whole(); !whole) return tl::unexpected(whole.error());
  auto map = load_map(out / "map.cloister");
  if (!map) return tl::unexpected(map.error());
  result.map = std::move(*map);
  return result;
}

std::vector<Cell> cells_of(const BenchContext& context, LiveTransport transport,
                           const CommandLine& line, const LiveFigures& live, const Replay& recorded,
                           const LoadedMap& map) {
  const MapDifference difference = compare_maps(map.view(), recorded.map.view());
  double worst = 0;
  std::size_t in_both = 0;
  for (const SubmapDifference& submap : difference.submaps) {
    in_both += submap.is_in_both ? 1 : 0;
    if (submap.observed > 0)
      worst = std::max(
          worst, static_cast<double>(submap.differing) / static_cast<double>(submap.observed));
  }
  double cpu_s = 0;
  for (const auto& [name, seconds] : live.cpu_s) cpu_s += seconds;
  return {{"date", context.date},
          {"machine", context.machine},
          {"commit", context.commit},
          {"mission", context.mission},
          {"transport", name_of(transport)},
          {"priority", std::to_string(line.live.priority)},
          {"machine_busy_pct", number(100 * live.machine_busy, 0)},
          {"transport_known_s", number(live.transport_known_s, 2)},
          {"scans_in_mission", std::to_string(recorded.scans)},
          {"refused_by_network", std::to_string(live.refused)},
          {"scans_received", std::to_string(live.received)},
          {"scans_integrated", std::to_string(live.integrated)},
          {"scans_lost", std::to_string(recorded.scans - live.integrated)},
          {"drops", list_of(live.drops)},
          {"latency_p50_ms", number(live.latency_ms.p50, 2)},
          {"latency_p99_ms", number(live.latency_ms.p99, 2)},
          {"latency_max_ms", number(live.latency_ms.max, 2)},
          {"scans_over_60_ms", std::to_string(live.over_limit)},
          {"scans_in_shared_memory", std::to_string(live.in_shared_memory)},
          {"loopback_bytes_per_scan", number(live.loopback_bytes_per_scan, 0)},
          {"integration_allocations",
           live.integration_allocations ? std::to_string(*live.integration_allocations) : ""},
          {"cpu_s", number(cpu_s, 2)},
          {"cpu_s_by_thread", list_of(live.cpu_s)},
          {"rss_peak_mb", number(1e-6 * static_cast<double>(live.rss_peak_bytes), 1)},
          {"map_peak_mb", number(1e-6 * static_cast<double>(live.map_bytes_peak), 2)},
          {"fusions", std::to_string(live.fusions)},
          {"submaps", std::to_string(map.submaps.size())},
          {"submaps_of_replay", std::to_string(recorded.map.submaps.size())},
          {"submaps_in_both", std::to_string(in_both)},
          {"observed_voxels", std::to_string(difference.observed())},
          {"differing_voxels", std::to_string(difference.differing())},
          {"differing_pct", number(100 * difference.share(), 4)},
          {"differing_worst_submap_pct", number(100 * worst, 4)}};
}

/// Simulates the mission, unless it is there.
Result<void> simulate(const CommandLine& line) {
  const fs::path mark = line.out / "mission.done";
  if (fs::exists(mark)) return {};
  const auto done =
      run_program({(line.live.programs / "cloister-simulate").string(), line.world, "--minutes",
                   number(line.minutes, 3), "--out", line.live.mission.string()},
                  line.out / "simulate.out", line.out / "simulate.log");
  if (done) std::ofstream(mark) << line.world << ' ' << line.minutes << '\n';
  return done;
}

Result<int> bench(CommandLine& line) {
  std::error_code error;
  fs::create_directories(line.out, error);
  line.out = fs::canonical(line.out, error);
  if (error)
    return fail(ErrorKind::kResource, line.out.string() + ": cannot be made: " + error.message());
  BenchContext context = context_here();
  context.commit = source_commit(CLOISTER_TREE, line.out);
  line.live.mission = line.out / "mission";
  context.mission = line.world + ", " + number(line.minutes, 1) + " min";
  if (const auto simulated = simulate(line); !simulated) return tl::unexpected(simulated.error());
  auto recorded = replay(line);
  if (!recorded) return tl::unexpected(recorded.error());
  line.live.num_scans = recorded->scans;

  std::vector<fs::path> keep = {line.out, line.live.programs, line.live.roudi_config.parent_path()};
  if (!line.results.empty()) {
    fs::create_directories(line.results, error);
    line.results = fs::absolute(line.results);
    keep.push_back(line.results);
  }
  const PrivateHost host(keep);
  if (!host.why_not().empty()) {
    std::fprintf(
        stderr,
        "cloister-bench-live: a network of its own is not permitted here (%s): run it as root\n",
        host.why_not().c_str());
    return kSkipped;
  }
  if (line.from_memory) {
    // The host's own, gone with this program.
    const fs::path copy = "/dev/shm/mission";
    fs::copy(line.live.mission, copy, fs::copy_options::recursive, error);
    if (error) {
      return fail(ErrorKind::kResource,
                  copy.string() + ": " + error.message() + ": leave --from-memory out");
    }
    line.live.mission = copy;
  }
  std::vector<std::vector<Cell>> rows;
  for (const std::string& name : line.transports) {
    const LiveTransport transport = live_transports().at(name);
    line.live.out = line.out / name;
    const auto figures = run_live_mission(transport, line.live);
    if (!figures) return tl::unexpected(figures.error());
    const auto map = load_map(line.live.out / "map.cloister");
    if (!map) return tl::unexpected(map.error());
    rows.push_back(cells_of(context, transport, line, *figures, *recorded, *map));
    if (line.results.empty()) continue;
    if (auto written = append_csv(line.results / "live.csv", {rows.back()}); !written)
      return tl::unexpected(written.error());
  }
  print_table(rows);
  std::printf(
      "\nlimits: no scan lost; latency_p99_ms 60; loopback far below a scan's own size with shared "
      "memory;\nno allocation; transport known in 2 s; as many submaps as the replay; 0.1 %% of "
      "voxels differ\n");
  return 0;
}

int run(int argc, char** argv) {
  CommandLine line;
  line.live.programs = program_folder();
  line.live.roudi_config = fs::path(CLOISTER_TREE) / "firmware_interface/dds/roudi.toml";
  CLI::App app(
      "Plays a simulated mission at its own pace to the mapper, once for each way that scans can "
      "take, in a network of its own, and says what was lost, how late scans were, what it cost, "
      "and how the map differs from that of the mission's replay.",
      "cloister-bench-live");
  std::set<std::string> known;
  for (const auto& [name, transport] : live_transports()) known.insert(name);
  app.add_option("--out", line.out,
                 "directory for the mission, maps and logs; a mission that is "
                 "there is used again")
      ->required();
  app.add_option("--world", line.world, "what is simulated")->capture_default_str();
  app.add_option("--minutes", line.minutes, "length of the mission")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--transport", line.transports, "only these (default: all but ros2)")
      ->check(CLI::IsMember(known));
  app.add_option("--set", line.live.settings, "a setting of the mapper and of the replay")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--priority", line.live.priority,
                 "real-time priority of mapper, player and RouDi, on a machine that others use too")
      ->check(CLI::Range(0, 99));
  app.add_flag("--from-memory", line.from_memory,
               "play a copy of the mission in memory: a disk that pauses has the player pause");
  app.add_option("--results", line.results, "append the results to live.csv in this directory");
  return run_program(app, argc, argv, [&] { return bench(line); });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
