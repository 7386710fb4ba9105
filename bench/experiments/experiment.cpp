#include "bench/experiments/experiment.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string_view>

#include "bench/support/child_program.hpp"
#include "bench/experiments/doubled_surface.hpp"
#include "bench/experiments/json_file.hpp"
#include "bench/experiments/pair_doubt.hpp"
#include "bench/experiments/rounds.hpp"
#include "bench/ground_truth/alignment.hpp"
#include "bench/simulate/number_text.hpp"
#include "bench/simulate/ply_file.hpp"

namespace cloister {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDoublingSamples = 200'000;
// Nodes between loop closures, so 30 m. A closure every few metres joins all submaps of a baseline, which fuses whatever
// a closure joins, into a single rigid one: nothing is left to compare with.
constexpr const char* kClosureSpacing = "15";
// Six gigabytes: what the baseline would need is what ours is compared with, not what a default budget leaves of it.
constexpr const char* kBaselineBudget = "memory.budget_bytes=6442450944";
// Where closures are put to the test, there must be many: 6 m.
constexpr const char* kFaultyClosureSpacing = "3";

struct Folders {
  fs::path home, mission, ours, baseline;
  bool has_clouds = false;

  /// What takes the gigabytes.
  [[nodiscard]] fs::path scans() const { return mission / (has_clouds ? "individual_clouds" : "lidar.pcap"); }
};

/// What the simulator is told about the graph's faults.
std::vector<std::string> fault_words(GraphFault fault) {
  switch (fault) {
    case GraphFault::kNone:
      return {};
    case GraphFault::kDoubtedClosures:
      return {"--wrong-closures", "0.05"};
    case GraphFault::kWrongClosures:
      return {"--confident-wrong-closures", "0.05"};
    case GraphFault::kLateShift:
      return {"--late-shift-m", "1"};
  }
  return {};
}

/// Runs one step, its output beside the results.
Result<void> step(const Folders& folders, const std::string& name,
                  const std::vector<std::string>& words) {
  std::fprintf(stderr, "%s: %s\n", folders.home.filename().c_str(), name.c_str());
  return run_program(words, folders.home / (name + ".out"), folders.home / (name + ".log"));
}

Result<void> run_programs(const ExperimentOptions& options, const Folders& folders,
                          const Experiment& experiment) {
  const auto program = [&](const char* name) { return (options.programs / name).string(); };
  std::vector<std::string> simulate = {
      program("cloister-simulate"),
      experiment.world,
      "--out",
      folders.mission.string(),
      "--seed",
      std::to_string(experiment.seed),
      "--closure-spacing",
      experiment.fault == GraphFault::kNone ? kClosureSpacing : kFaultyClosureSpacing};
  for (const std::string& word : fault_words(experiment.fault)) simulate.push_back(word);
  if (experiment.clouds) {
    simulate.emplace_back("--clouds");
    simulate.push_back(name_of(cloud_kind_names(), *experiment.clouds));
  }
  if (options.minutes > 0.0) {
    simulate.emplace_back("--minutes");
    append_number(options.minutes, &simulate.emplace_back());
  }
  const std::string mission = folders.mission.string();
  const std::string ours = folders.ours.string();
  const std::pair<const char*, std::vector<std::string>> steps[] = {
      {"simulate", simulate},
      {"replay", {program("cloister"), "replay", mission, "--out", ours}},
      {"baseline",
       {program("cloister"), "replay", mission, "--out", folders.baseline.string(), "--baseline",
        "--set", kBaselineBudget}},
      {"ground_truth",
       {program("cloister-ground-truth"), mission, ours, "--cloister", program("cloister")}},
      {"final_map",
       {program("cloister-bench-final-map"), mission, ours, "--returns",
        (folders.home / "returns.f32").string()}},
  };
  // The simulator's last act is to give the folder its name: what is there is whole.
  std::error_code error;
  const bool has_mission = options.keep && fs::exists(folders.scans(), error);
  for (const auto& [name, words] : steps) {
    if (has_mission && std::string_view(name) == "simulate") continue;
    if (const auto done = step(folders, name, words); !done) return done;
  }
  return {};
}

Result<void> read_judgement(const Folders& folders, Experiment* experiment) {
  auto file = JsonFile::open(folders.home / "ground_truth.out");
  if (!file) return tl::unexpected(file.error());
  const auto real = [&](const char* at) { return file->number<double>(at); };
  experiment->trajectory_rms_m = real("/trajectory/rms_m");
  experiment->mesh = {real("/mesh/within_5cm"), real("/mesh/within_10cm"),
                      real("/mesh/within_25cm")};
  experiment->complete_10cm = real("/mesh/complete_10cm");
  experiment->rand_index = real("/rooms/adjusted_rand_index");
  if (const auto whole = file->is_whole(); !whole) return whole;
  for (const auto& room : file->root()["rooms"].value("rooms", nlohmann::json::array())) {
    const bool is_middle = room.is_object() && room.contains("name") && room.contains("scans") &&
                           room.contains("submaps") && room["name"].is_string() &&
                           room["scans"].is_number_integer() &&
                           room["submaps"].is_number_integer() &&
                           room["name"].get<std::string>().starts_with("middle");
    if (is_middle && room["scans"].get<std::int64_t>() > 0)
      experiment->middle_room_submaps = room["submaps"].get<std::int64_t>();
  }
  return {};
}

/// Which of the pairs the replay left could have been fused, by the last graph it was given.
Result<void> count_pairs(const ExperimentOptions& options, const Folders& folders,
                         Experiment* experiment) {
  const auto file = JsonFile::open(folders.home / "final_map.out");
  if (!file) return tl::unexpected(file.error());
  const auto pairs = read_root_pairs(file->root());
  if (!pairs) return tl::unexpected(pairs.error());
  const auto doubts = ask_doubts_m(options.programs / "cloister", folders.mission / "pose_graph",
                                   folders.home, *pairs);
  if (!doubts) return tl::unexpected(doubts.error());
  for (const double doubt_m : *doubts) {
    (doubt_m <= experiment->ours.max_sigma_m ? experiment->overlapping_pairs
                                             : experiment->doubtful_pairs) += 1;
  }
  return {};
}

Result<Nearness> judge_returns(const fs::path& file, const Pose& T_W_M, const RayScene& truth_W) {
  std::ifstream stream(file, std::ios::binary);
  std::size_t within[3] = {0, 0, 0};
  std::size_t count = 0;
  Eigen::Vector3f p_M;
  while (stream.read(reinterpret_cast<char*>(p_M.data()), 3 * sizeof(float))) {
    const float distance_m = truth_W.distance((T_W_M * p_M.cast<double>()).cast<float>(), 1.0F);
    within[0] += distance_m <= 0.05F ? 1 : 0;
    within[1] += distance_m <= 0.10F ? 1 : 0;
    within[2] += distance_m <= 0.25F ? 1 : 0;
    ++count;
  }
  if (count == 0)
    return fail(ErrorKind::kInput, file.string() + ": holds no returns: replay the mission again");
  const auto share = [&](std::size_t part) {
    return static_cast<double>(part) / static_cast<double>(count);
  };
  return Nearness{share(within[0]), share(within[1]), share(within[2])};
}

/// What is measured here, with the truth at hand.
Result<void> judge(const ExperimentOptions& options, const Folders& folders,
                   Experiment* experiment) {
  const auto truth = read_ground_truth(folders.mission);
  if (!truth) return tl::unexpected(truth.error());
  const auto estimate = read_tum(folders.ours / "trajectory.tum");
  if (!estimate) return tl::unexpected(estimate.error());
  const auto submaps = read_submaps(folders.ours / "submaps.json");
  if (!submaps) return tl::unexpected(submaps.error());
  const auto mesh_M = read_ply(folders.ours / "mesh.ply");
  if (!mesh_M) return tl::unexpected(mesh_M.error());
  const auto truth_W = RayScene::build(truth->mesh_W);
  if (!truth_W) return tl::unexpected(truth_W.error());
  const Pose T_W_M = align(*estimate, truth->T_W_L).T_W_M;

  const auto doubled =
      find_doubled_surface(*mesh_M, LocalAlignment(*estimate, truth->T_W_L), *truth_W,
                           kDoublingSamples, experiment->seed);
  if (!doubled) return tl::unexpected(doubled.error());
  experiment->doubled_share = doubled->share();
  experiment->doubled_far_share = doubled->far_share();
  const auto returns = judge_returns(folders.home / "returns.f32", T_W_M, *truth_W);
  if (!returns) return tl::unexpected(returns.error());
  experiment->returns = *returns;
  experiment->submaps_across_storeys = submaps_across_storeys(*truth, *submaps);
  const auto wrong = read_wrong_closures(folders.mission / "ground_truth" / "wrong_closures.csv");
  if (!wrong) return tl::unexpected(wrong.error());
  experiment->wrong_closures = wrong->size();
  for (const auto& [from, to] : *wrong) {
    experiment->fused_across += std::any_of(submaps->begin(), submaps->end(), [&](const auto& s) {
      return s.holds_node(from) && s.holds_node(to);
    });
  }
  if (experiment->world == "small-rooms") experiment->round_ends = round_ends(*truth);
  const double length_s = (truth->T_W_L.back().stamp - truth->T_W_L.front().stamp).seconds();
  experiment->is_cut_short = options.minutes > 0.0 && length_s > options.minutes * 60.0 - 1.0;
  return {};
}

}  // namespace

double Experiment::memory_saved() const {
  return baseline.map_bytes_final > 0 ? 1.0 - static_cast<double>(ours.map_bytes_final) /
                                                  static_cast<double>(baseline.map_bytes_final)
                                      : 0.0;
}

std::vector<std::int64_t> Experiment::round_bytes() const {
  std::vector<std::int64_t> bytes;
  for (const SensorTime end : round_ends) bytes.push_back(map_bytes_at(ours.growth, end));
  return bytes;
}

const std::map<std::string, GraphFault>& graph_fault_names() {
  static const std::map<std::string, GraphFault> names = {
      {"none", GraphFault::kNone},
      {"doubted-closures", GraphFault::kDoubtedClosures},
      {"wrong-closures", GraphFault::kWrongClosures},
      {"late-shift", GraphFault::kLateShift}};
  return names;
}

std::string experiment_name(const Experiment& experiment) {
  std::string name = experiment.world + "_" + std::to_string(experiment.seed);
  if (experiment.fault != GraphFault::kNone) name += "_" + name_of(graph_fault_names(), experiment.fault);
  if (experiment.clouds) name += "_" + name_of(cloud_kind_names(), *experiment.clouds);
  return name;
}

Result<Experiment> run_experiment(const ExperimentOptions& options, const std::string& world,
                                  std::uint64_t seed) {
  Experiment experiment;
  experiment.world = world;
  experiment.seed = seed;
  experiment.fault = options.fault;
  experiment.clouds = options.clouds;
  const fs::path home = options.out / experiment_name(experiment);
  const Folders folders{home, home / "mission", home / "ours", home / "baseline", options.clouds.has_value()};
  std::error_code error;
  fs::create_directories(home, error);
  if (error)
    return fail(ErrorKind::kResource, home.string() + ": cannot be made: " + error.message());
  const auto done = run_programs(options, folders, experiment);
  // Gigabytes that are simulated again in less time than it takes to miss them.
  if (!options.keep) fs::remove_all(folders.scans(), error);
  if (!done) return tl::unexpected(done.error());

  auto ours = read_replay(folders.ours);
  if (!ours) return tl::unexpected(ours.error());
  experiment.ours = std::move(*ours);
  auto baseline = read_replay(folders.baseline);
  if (!baseline) return tl::unexpected(baseline.error());
  experiment.baseline = std::move(*baseline);
  for (const auto& result :
       {read_judgement(folders, &experiment), count_pairs(options, folders, &experiment),
        judge(options, folders, &experiment)}) {
    if (!result) return tl::unexpected(result.error());
  }
  if (!options.keep) fs::remove(home / "returns.f32", error);
  return experiment;
}

}  // namespace cloister
