#include <unistd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "runtime/app/map_commands.hpp"
#include "runtime/app/play_command.hpp"
#include "runtime/app/replay_command.hpp"
#include "runtime/app/run_command.hpp"
#include "runtime/app/topics_command.hpp"
#include "runtime/app/version.hpp"
#include "runtime/config_file.hpp"

namespace cloister {
namespace {

/// Becomes the simulator, a program of its own beside this one: it must not share code with the decoder it tests.
Result<void> run_simulator(const std::vector<std::string>& arguments) {
  std::error_code error;
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "cloister-simulate";
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  return fail(ErrorKind::kResource, program.string() + ": cannot be started; is the simulator built and installed?");
}

struct ConfigSource {
  std::optional<std::filesystem::path> file;
  std::vector<std::string> settings;

  void add_to(CLI::App& command) {
    command.add_option("--config", file, "TOML file with settings")->type_name("FILE");
    command.add_option("--set", settings, "one setting, as in voxel.voxel_size_m=0.1; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
  }
};

int run(int argc, char** argv) {
  // The simulator has its own command line, with its own help.
  if (argc > 1 && std::string(argv[1]) == "simulate") {
    const auto failed = run_simulator({argv + 2, argv + argc});
    std::fprintf(stderr, "cloister: %s\n", failed.error().message.c_str());
    return static_cast<int>(failed.error().kind);
  }

  CLI::App app("Elastic LiDAR occupancy mapping that scales with the place, not with the time.", "cloister");
  app.set_version_flag("--version", std::string("cloister ") + kVersion);
  app.require_subcommand(1);
  std::function<Result<void>()> action;
  ConfigSource source;

  ReplayOptions replay;
  bool baseline = false;
  bool force_progress = false;
  CLI::App* replay_command = app.add_subcommand("replay", "map a recorded mission and write its map and reports");
  replay_command->add_option("mission", replay.mission, "mission directory, or recording of rosbag2 (.db3)")->required()->type_name("MISSION");
  replay_command->add_option("--out", replay.out, "directory for the outputs")->required()->type_name("OUT");
  source.add_to(*replay_command);
  replay_command->add_flag("--baseline", baseline,
                           "spawn by distance, fuse at loop closures only, no uncertainty check (for comparison)");
  replay_command->add_flag("--realtime", replay.realtime, "at the pace of the stamps; scans that come too late are dropped");
  replay_command->add_flag("--progress", force_progress, "show progress even when stderr is not a terminal");
  replay_command->callback([&] {
    action = [&]() -> Result<void> {
      auto config = load_config(source.file, source.settings);
      if (!config) return tl::unexpected(config.error());
      config->map.baseline |= baseline;
      replay.show_progress = force_progress || isatty(STDERR_FILENO) != 0;
      return run_replay(replay, *config);
    };
  });

  RunOptions live;
  CLI::App* run_command = app.add_subcommand("run", "map a live mission, over DDS or straight from the sensor, until SIGTERM");
  run_command->add_option("--out", live.out, "directory for the outputs")->required()->type_name("OUT");
  source.add_to(*run_command);
  run_command->add_flag("--progress", force_progress, "show progress even when stderr is not a terminal");
  run_command->callback([&] {
    action = [&]() -> Result<void> {
      const auto config = load_config(source.file, source.settings);
      if (!config) return tl::unexpected(config.error());
      live.show_progress = force_progress || isatty(STDERR_FILENO) != 0;
      return run_live(live, *config);
    };
  });

  PlayOptions play;
  CLI::App* play_command = app.add_subcommand("play", "publish a recorded mission as the robot would");
  play_command->add_option("mission", play.mission, "mission directory")->required()->type_name("MISSION");
  play_command->add_option("--rate", play.rate, "times the mission's own pace")->type_name("R")->check(CLI::Range(0.01, 100.0));
  play_command->add_option("--start", play.start_s, "where to begin, seconds into the mission")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  CLI::Option* as_packets =
      play_command->add_flag("--udp", play.raw_packets, "send the sensor's packets in place of scans over DDS");
  play_command->add_flag("--ros2", play.as_ros2, "publish what drivers under ROS 2 would: clouds, odometry, path, tf_static")
      ->excludes(as_packets);
  play_command->add_option("--host", play.host, "where to send packets")->type_name("HOST");
  play_command->add_option("--port", play.port, "which port to send packets to")->type_name("PORT")->check(CLI::Range(1, 65535));
  source.add_to(*play_command);
  play_command->callback([&] {
    action = [&]() -> Result<void> {
      const auto config = load_config(source.file, source.settings);
      if (!config) return tl::unexpected(config.error());
      return run_play(play, *config);
    };
  });

  double watch_s = 3.0;
  CLI::App* topics_command = app.add_subcommand("topics", "print rates and sizes of what is on the wire");
  topics_command->add_option("--seconds", watch_s, "how long to watch")->type_name("S")->check(CLI::Range(0.1, 3600.0));
  source.add_to(*topics_command);
  topics_command->callback([&] {
    action = [&]() -> Result<void> {
      const auto config = load_config(source.file, source.settings);
      if (!config) return tl::unexpected(config.error());
      return run_topics(watch_s, *config);
    };
  });

  app.add_subcommand("simulate", "make a mission with ground truth: see cloister simulate --help");

  std::filesystem::path map;
  std::filesystem::path points;
  CLI::App* query_command = app.add_subcommand("query", "tell for points of a CSV file whether they are occupied");
  query_command->add_option("map", map, "map.cloister of a mission's outputs")->required()->type_name("MAP");
  query_command->add_option("points", points, "CSV file with x,y,z in the map frame")->required()->type_name("POINTS.csv");
  query_command->callback([&] { action = [&] { return run_query(map, points); }; });

  std::filesystem::path export_path;
  bool export_cloud = false;
  CLI::App* export_command = app.add_subcommand("export", "write a map as .ply, .pcd, .bt, .ot or .vdb");
  export_command->add_option("map", map, "map.cloister of a mission's outputs")->required()->type_name("MAP");
  export_command->add_option("--out", export_path, "file to write; its suffix names the format")->required()->type_name("FILE");
  export_command->add_flag("--cloud", export_cloud, "for .ply: occupied voxels as a cloud instead of the mesh");
  export_command->callback([&] { action = [&] { return run_export(map, export_path, export_cloud); }; });

  std::filesystem::path graph;
  std::filesystem::path pairs;
  double default_information = 0;
  bool gtsam_default = false;
  CLI::App* uncertainty_command =
      app.add_subcommand("uncertainty", "relative covariances of node pairs of a pose graph");
  uncertainty_command->add_option("graph", graph, "pose graph in g2o text")->required()->type_name("GRAPH.g2o");
  uncertainty_command->add_option("pairs", pairs, "CSV file with i,j")->required()->type_name("PAIRS.csv");
  uncertainty_command->add_option("--default-information", default_information,
                                  "stands in for missing information matrices, 1/m^2 and 1/rad^2");
  uncertainty_command->add_flag("--gtsam-default", gtsam_default,
                                "leave the residuals' Jacobians out, as GTSAM does unless told otherwise");
  uncertainty_command->callback(
      [&] { action = [&] { return run_uncertainty(graph, pairs, default_information, gtsam_default); }; });

  CLI::App* config_command = app.add_subcommand("config", "print the configuration that the given options make, as TOML");
  source.add_to(*config_command);
  config_command->callback([&] {
    action = [&]() -> Result<void> {
      const auto config = load_config(source.file, source.settings);
      if (!config) return tl::unexpected(config.error());
      std::cout << to_toml(*config);
      return {};
    };
  });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "cloister: %s; see cloister --help\n", error.what());
    return static_cast<int>(ErrorKind::kUsage);
  }
  const Result<void> done = action();
  if (done) return 0;
  std::fprintf(stderr, "cloister: %s\n", done.error().message.c_str());
  return static_cast<int>(done.error().kind);
}

}  // namespace
}  // namespace cloister

int main(int argc, char** argv) {
  try {
    return cloister::run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "cloister: not enough memory; set memory.budget_bytes lower\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cloister: %s\n", error.what());
  }
  return static_cast<int>(cloister::ErrorKind::kResource);
}
