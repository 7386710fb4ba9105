#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/replay_figures.hpp"
#include "bench/simulate/cloud_writer.hpp"

namespace cloister {

/// Shares of points within a distance of the true surface, 0 to 1.
struct Nearness {
  double within_5cm = 0.0;
  double within_10cm = 0.0;
  double within_25cm = 0.0;
};

/// What is wrong with a mission's pose graphs.
enum class GraphFault {
  kNone,
  kDoubtedClosures,  ///< one loop closure in twenty is wrong, and its information admits it
  kWrongClosures,    ///< one in twenty is wrong and looks as good as the others
  kLateShift         ///< the old half of all nodes moves by a metre, late in the mission
};

/// As on the command line: none, doubted-closures, wrong-closures, late-shift.
[[nodiscard]] const std::map<std::string, GraphFault>& graph_fault_names();

/// Everything that one world with one seed says.
struct Experiment {
  std::string world;
  std::uint64_t seed = 1;
  GraphFault fault = GraphFault::kNone;
  std::optional<CloudKind> clouds;  ///< what the mission has in place of packets
  bool is_cut_short = false;  ///< the mission ended before its path did

  ReplayFigures ours;
  ReplayFigures baseline;

  double rand_index = 0.0;  ///< adjusted, between final submaps and rooms
  double trajectory_rms_m = 0.0;
  Nearness mesh;
  Nearness returns;                ///< of raw returns placed by the final graph: a perfect mapper's
  double complete_10cm = 0.0;      ///< share of the seen true surface that has mesh within 10 cm
  double doubled_share = 0.0;      ///< of the mesh's area
  double doubled_far_share = 0.0;  ///< of the mesh's area, by sheets more than 10 cm apart
  std::size_t overlapping_pairs =
      0;  ///< of final submaps: voxel overlap above 0.7, certain enough to be fused
  std::size_t doubtful_pairs = 0;  ///< the same, but too uncertain to be fused
  std::size_t submaps_across_storeys = 0;
  std::size_t wrong_closures = 0;  ///< in the graph
  std::size_t fused_across = 0;    ///< of these, how many have both ends in one final submap
  std::optional<std::int64_t> middle_room_submaps;  ///< where there is a middle room with scans
  std::vector<SensorTime> round_ends;

  /// Share of the baseline's memory at the end that ours does without.
  [[nodiscard]] double memory_saved() const;
  /// The map's bytes after each round.
  [[nodiscard]] std::vector<std::int64_t> round_bytes() const;
};

/// The folder of an experiment: WORLD_SEED[_FAULT][_CLOUDS].
[[nodiscard]] std::string experiment_name(const Experiment& experiment);
/// The name of one of a map's values.
template <typename Value>
[[nodiscard]] std::string name_of(const std::map<std::string, Value>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return {};
}

/// What to run, and where.
struct ExperimentOptions {
  std::filesystem::path out;       ///< gets WORLD_SEED[_FAULT][_CLOUDS]/{mission,ours,baseline}
  std::filesystem::path programs;  ///< folder of the programs
  double minutes = 0.0;            ///< missions end there; 0 = at the end of their paths
  GraphFault fault = GraphFault::kNone;
  std::optional<CloudKind> clouds;
  bool keep = false;  ///< keep the missions' packets or clouds, and use those that are there
};

/// Simulates a mission, replays it twice and judges what is left. Says what it does on stderr.
/// Errors: those of the programs, naming their logs; kInput for a result that cannot be read
[[nodiscard]] Result<Experiment> run_experiment(const ExperimentOptions& options,
                                                const std::string& world, std::uint64_t seed);

}  // namespace cloister
