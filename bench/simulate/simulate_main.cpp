#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>

#include "bench/simulate/mission_writer.hpp"
#include "bench/simulate/path_file.hpp"
#include "bench/simulate/ply_file.hpp"
#include "bench/simulate/walk.hpp"
#include "bench/simulate/world.hpp"
#include "bench/support/program.hpp"

namespace cloister {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

struct CommandLine {
  std::string world;
  std::string path_file;
  std::string sensor;  ///< empty: the world's own
  WalkConfig walk;
  MissionOptions mission;
  double skip_minutes = 0.0;
  int rate_hz = 10;
  int columns = 1024;
  double noise_m = -1.0;
  double dropout = -1.0;
  bool progress = false;
};

void declare(CommandLine* line, CLI::App* app) {
  std::string names;
  for (const std::string& name : world_names()) names += name + ", ";
  app->add_option("WORLD", line->world,
                  names + "or a triangle mesh (.ply) to walk through along --path")
      ->required();
  app->add_option("--out", line->mission.out, "directory of the mission to write")->required();
  app->add_option(
      "--path", line->path_file,
      "way through the world: a TUM trajectory, or lines of x y z [pause_s] to walk through");
  app->add_option("--seed", line->mission.seed, "changes doors, furniture, trees, path and noise")
      ->capture_default_str();
  app->add_option("--minutes", line->mission.max_minutes,
                  "end the mission there (default: at the end of the path)")
      ->check(CLI::PositiveNumber);
  app->add_option("--skip", line->skip_minutes, "begin the mission so many minutes into the path")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--sensor", line->sensor, "os0-64 or os1-64 (default: the world's own)");
  app->add_option("--rate", line->rate_hz, "revolutions per second")
      ->check(CLI::IsMember({10, 20}))
      ->capture_default_str();
  app->add_option("--columns", line->columns, "columns per revolution")
      ->check(CLI::IsMember({512, 1024, 2048}))
      ->capture_default_str();
  app->add_option("--speed", line->walk.speed_mps, "walking speed in m/s")
      ->check(CLI::Range(0.1, 5.0))
      ->capture_default_str();
  app->add_option("--noise", line->noise_m,
                  "standard deviation of a range in metres (default: the sensor's)")
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--dropout", line->dropout,
                  "share of pixels lost at random (default: the sensor's)")
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--drift", line->mission.drift.percent,
                  "odometry error in per cent of 20 m walked")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  app->add_option("--snapshot-every", line->mission.slam.publish_every,
                  "graph nodes per pose-graph snapshot")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app->add_option("--closure-spacing", line->mission.slam.min_closure_spacing,
                  "graph nodes (of 2 m) between two loop closures, at least")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app->add_option("--wrong-closures", line->mission.slam.wrong_closures,
                  "share of loop closures that are wrong, with information that admits their doubt")
      ->check(CLI::Range(0.0, 0.5));
  app->add_option("--confident-wrong-closures", line->mission.slam.confident_wrong_closures,
                  "share of loop closures that are wrong, with the information of good ones")
      ->check(CLI::Range(0.0, 0.5));
  app->add_option(
         "--late-shift-m", line->mission.slam.late_shift_m,
         "metres by which the optimiser moves the old half of the nodes late in the mission")
      ->check(CLI::Range(0.0, 20.0));
  app->add_option("--clouds", line->mission.clouds,
                  "one cloud a graph node, in place of packets and odometry: scans (the last revolution), or gathered "
                  "(every fourth beam and column since the node before)")
      ->transform(CLI::CheckedTransformer(cloud_kind_names()));
  app->add_option("--threads", line->mission.threads, "threads to simulate on (default: all)")
      ->check(CLI::Range(1, 256));
  app->add_flag("--progress", line->progress, "print progress even when stderr is not a terminal");
}

Result<World> load_world(const CommandLine& line) {
  const auto names = world_names();
  if (std::find(names.begin(), names.end(), line.world) != names.end()) {
    return make_world(line.world, line.mission.seed);
  }
  if (!line.world.ends_with(".ply")) return make_world(line.world, line.mission.seed);
  if (line.path_file.empty()) {
    return fail(ErrorKind::kUsage,
                line.world + ": a mesh needs a way through it: give --path FILE");
  }
  auto mesh = read_ply(line.world);
  if (!mesh) return tl::unexpected(mesh.error());
  World world;
  world.name = std::filesystem::path(line.world).stem().string();
  world.mesh = std::move(*mesh);
  return world;
}

Result<MissionSummary> simulate(CommandLine line) {
  const auto world = load_world(line);
  if (!world) return tl::unexpected(world.error());
  auto sensor = make_sensor(line.sensor.empty() ? world->sensor : line.sensor);
  if (!sensor) return tl::unexpected(sensor.error());
  if (line.columns == 2048 && line.rate_hz == 20) {
    return fail(ErrorKind::kUsage,
                "--columns 2048 --rate 20: the sensor has no such mode: lower one of them");
  }
  sensor->columns = line.columns;
  sensor->rate_hz = line.rate_hz;
  if (line.noise_m >= 0.0) sensor->noise_m = line.noise_m;
  if (line.dropout >= 0.0) sensor->dropout = line.dropout;
  line.mission.sensor = *sensor;

  Result<Trajectory> truth;
  if (line.path_file.empty()) {
    truth = walk(world->path, line.walk, kMissionStart, line.mission.seed);
  } else {
    truth = read_path(line.path_file, line.walk, kMissionStart, line.mission.seed);
  }
  if (!truth) return tl::unexpected(truth.error());
  const double skipped = line.skip_minutes * 60.0 / truth->step.seconds();
  if (skipped + 1.0 > static_cast<double>(truth->poses.size())) {
    return fail(ErrorKind::kUsage, "--skip: the path is over before that: skip less");
  }
  truth->poses.erase(truth->poses.begin(),
                     truth->poses.begin() + static_cast<std::ptrdiff_t>(skipped));

  const bool show = line.progress || isatty(STDERR_FILENO) != 0;
  const Progress progress = [show](std::uint64_t done, std::uint64_t all) {
    if (!show) return;
    std::fprintf(stderr, "\rscan %llu of %llu%s", static_cast<unsigned long long>(done),
                 static_cast<unsigned long long>(all), done == all ? "\n" : "");
  };
  return write_mission(*world, std::move(*truth), line.mission, interrupted, progress);
}

int run(int argc, char** argv) {
  CLI::App app(
      "Simulates a mission: Ouster packets, odometry, pose graphs and the truth about them.",
      "cloister simulate");
  CommandLine line;
  line.mission.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  declare(&line, &app);
  return run_program(app, argc, argv, [&]() -> Result<int> {
    const auto on_signal = [](int) { interrupted.store(true, std::memory_order_relaxed); };
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    const auto summary = simulate(line);
    if (!summary) return tl::unexpected(summary.error());
    std::printf("%s: %llu scans, %.1f s, %.1f m, %zu graph nodes, %d loop closures, %.1f MB\n",
                line.mission.out.c_str(), static_cast<unsigned long long>(summary->scans),
                summary->seconds, summary->metres, summary->nodes, summary->loop_closures,
                static_cast<double>(summary->bytes) * 1e-6);
    if (!summary->interrupted) return 0;
    std::fprintf(stderr, "cloister simulate: interrupted: the mission is complete up to there\n");
    return static_cast<int>(ErrorKind::kInterrupted);
  });
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) { return cloister::run(argc, argv); }
