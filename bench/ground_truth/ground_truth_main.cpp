#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/ground_truth/alignment.hpp"
#include "bench/ground_truth/mesh_accuracy.hpp"
#include "bench/ground_truth/room_accuracy.hpp"
#include "bench/ground_truth/state_accuracy.hpp"
#include "bench/simulate/ply_file.hpp"
#include "bench/support/child_program.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path mission;
  fs::path out;
  fs::path cloister;
  fs::path json;
  std::size_t points = 100'000;
  std::size_t samples = 200'000;
  double clearance_m = 0.10;
  std::uint64_t seed = 1;
};

struct Report {
  std::size_t poses = 0;
  Alignment alignment;
  StateAccuracy states;
  MeshAccuracy mesh;
  RoomAccuracy rooms;
};

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Asks the map about sampled points, through files in a directory of its own.
Result<StateAccuracy> ask_map(const Options& options, const GroundTruth& truth,
                              const RayScene& scene_W, const Pose& T_W_M) {
  const auto points =
      sample_points(truth, scene_W, options.points, options.clearance_m, options.seed);
  const fs::path scratch =
      fs::temp_directory_path() / ("cloister-ground-truth-" + std::to_string(getpid()));
  struct Cleanup {
    const fs::path& path;
    ~Cleanup() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  } const cleanup{scratch};
  std::error_code error;
  fs::create_directories(scratch, error);
  std::ofstream stream(scratch / "points.csv", std::ios::binary);
  stream << format_points(points, T_W_M);
  stream.close();
  if (error || !stream)
    return fail(ErrorKind::kResource, scratch.string() + ": cannot be written: free some space");
  const auto asked = run_program({options.cloister.string(), "query",
                                  (options.out / "map.cloister").string(),
                                  (scratch / "points.csv").string()},
                                 scratch / "states.csv", {});
  if (!asked) return tl::unexpected(asked.error());
  const auto states = read_states(scratch / "states.csv", points.size());
  if (!states) return tl::unexpected(states.error());
  return compare_states(points, *states);
}

Result<Report> judge(const Options& options) {
  const auto truth = read_ground_truth(options.mission);
  if (!truth) return tl::unexpected(truth.error());
  const auto estimate = read_tum(options.out / "trajectory.tum");
  if (!estimate) return tl::unexpected(estimate.error());
  const auto submaps = read_submaps(options.out / "submaps.json");
  if (!submaps) return tl::unexpected(submaps.error());
  const auto mesh_M = read_ply(options.out / "mesh.ply");
  if (!mesh_M) return tl::unexpected(mesh_M.error());
  const auto scene_W = RayScene::build(truth->mesh_W);
  if (!scene_W) return tl::unexpected(scene_W.error());

  Report report;
  report.poses = estimate->size();
  report.alignment = align(*estimate, truth->T_W_L);
  const auto states = ask_map(options, *truth, *scene_W, report.alignment.T_W_M);
  if (!states) return tl::unexpected(states.error());
  report.states = *states;
  const auto mesh = compare_mesh(*mesh_M, report.alignment.T_W_M, *truth, *scene_W, options.samples,
                                 options.seed);
  if (!mesh) return tl::unexpected(mesh.error());
  report.mesh = *mesh;
  report.rooms = compare_rooms(*truth, *submaps);
  return report;
}

nlohmann::ordered_json to_json(const Report& r) {
  nlohmann::ordered_json rooms = nlohmann::ordered_json::array();
  std::size_t most = 0;
  for (const RoomShare& s : r.rooms.rooms) {
    rooms.push_back({{"id", s.room.id},
                     {"name", s.room.name},
                     {"storey", s.room.storey},
                     {"scans", s.scans},
                     {"submaps", s.submaps}});
    most = std::max(most, s.submaps);
  }
  const StateAccuracy& s = r.states;
  const MeshAccuracy& m = r.mesh;
  return {{"trajectory",
           {{"poses", r.poses}, {"rms_m", r.alignment.rms_m}, {"max_m", r.alignment.max_m}}},
          {"states",
           {{"points", s.points},
            {"known_free", s.known_free},
            {"known_free_right", share(s.known_free_right, s.known_free)},
            {"known_occupied", s.known_occupied},
            {"known_occupied_wrong", share(s.known_occupied_wrong, s.known_occupied)},
            {"unknown", share(s.unknown, s.points)},
            {"free_space_known_free", share(s.known_free_right, s.truly_free)}}},
          {"mesh",
           {{"samples", m.samples},
            {"within_5cm", m.within_5cm},
            {"within_10cm", m.within_10cm},
            {"within_25cm", m.within_25cm},
            {"mean_m", m.mean_m},
            {"p95_m", m.p95_m},
            {"max_m", m.max_m},
            {"surface_samples", m.surface_samples},
            {"complete_10cm", m.complete_10cm}}},
          {"rooms",
           {{"final_submaps", r.rooms.final_submaps},
            {"max_submaps_per_room", most},
            {"adjusted_rand_index", r.rooms.adjusted_rand_index},
            {"scans", r.rooms.scans},
            {"rooms", rooms}}}};
}

void print_table(const Report& r) {
  const StateAccuracy& s = r.states;
  const MeshAccuracy& m = r.mesh;
  std::fprintf(stderr,
               "trajectory  %zu poses, %.1f cm rms and %.1f cm at most after rigid alignment\n",
               r.poses, 100.0 * r.alignment.rms_m, 100.0 * r.alignment.max_m);
  std::fprintf(
      stderr,
      "states      %zu points: known free %.2f %% right (%zu), known occupied %.2f %% wrong (%zu), "
      "%.2f %% unknown\n",
      s.points, 100.0 * share(s.known_free_right, s.known_free), s.known_free,
      100.0 * share(s.known_occupied_wrong, s.known_occupied), s.known_occupied,
      100.0 * share(s.unknown, s.points));
  std::fprintf(stderr,
               "mesh        within 5/10/25 cm: %.2f / %.2f / %.2f %%, mean %.1f cm, 95th "
               "percentile %.1f cm, "
               "covers %.2f %% of the seen surface\n",
               100.0 * m.within_5cm, 100.0 * m.within_10cm, 100.0 * m.within_25cm, 100.0 * m.mean_m,
               100.0 * m.p95_m, 100.0 * m.complete_10cm);
  std::fprintf(stderr, "rooms       %zu final submaps, adjusted Rand index %.3f over %zu scans\n",
               r.rooms.final_submaps, r.rooms.adjusted_rand_index, r.rooms.scans);
  for (const RoomShare& room : r.rooms.rooms) {
    std::fprintf(stderr, "  storey %d  %-14s %5zu scans  %zu submaps\n", room.room.storey,
                 room.room.name.c_str(), room.scans, room.submaps);
  }
}

/// The program beside this one, unless named.
fs::path default_cloister() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return self.parent_path() / "cloister";
}

int run(int argc, char** argv) {
  Options options;
  options.cloister = default_cloister();
  CLI::App app(
      "Compares what a replay left with the truth of a simulated mission: JSON to stdout, a table "
      "to stderr.",
      "cloister-ground-truth");
  app.add_option("MISSION", options.mission, "the simulated mission, with its ground_truth/")
      ->required();
  app.add_option("OUT", options.out, "what the replay of it left")->required();
  app.add_option("--cloister", options.cloister,
                 "the program that answers queries (default: beside this one)");
  app.add_option("--json", options.json, "also write the numbers to this file");
  app.add_option("--points", options.points, "points to ask the map about")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  app.add_option("--samples", options.samples, "points to sample on the mesh")
      ->check(CLI::Range(10, 100'000'000))
      ->capture_default_str();
  app.add_option("--clearance", options.clearance_m,
                 "distance of asked points from every surface, metres")
      ->check(CLI::Range(0.001, 2.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "chooses the sampled points")->capture_default_str();
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto report = judge(options);
    if (!report) return tl::unexpected(report.error());
    print_table(*report);
    const std::string text = to_json(*report).dump(2) + "\n";
    std::fputs(text.c_str(), stdout);
    if (options.json.empty()) return 0;
    std::ofstream stream(options.json);
    stream << text;
    stream.close();
    if (!stream) {
      std::fprintf(stderr, "cloister-ground-truth: %s: cannot be written: check the path\n",
                   options.json.c_str());
      return static_cast<int>(ErrorKind::kResource);
    }
    return 0;
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
