#include "bench/simulate/graph_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include "bench/simulate/slam_standin.hpp"
#include "bench/simulate/walk.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'700'000'000'250'000'000};

/// Seven rounds of 64 m.
Trajectory walk_rounds() {
  std::vector<Waypoint> path;
  for (int round = 0; round < 7; ++round) {
    for (const auto& [x, y] : std::array<std::array<double, 2>, 4>{
             {{0.0, 0.0}, {16.0, 0.0}, {16.0, 16.0}, {0.0, 16.0}}}) {
      path.push_back({{x, y, 1.0}, 0.0});
    }
  }
  return walk(path, WalkConfig{}, kStart, 1);
}

SlamRun run_with(const Trajectory& truth, const SlamConfig& config) {
  const DriftConfig drift;
  return run_slam(
      truth, corrupt(truth, drift, 1), drift, config,
      [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return true; }, 1);
}

double worst_node_m(const SlamRun& run, const Trajectory& truth) {
  double worst = 0.0;
  for (std::size_t k = 0; k < run.T_M_nodes.size(); ++k) {
    worst = std::max(
        worst,
        (run.T_M_nodes[k].translation() - truth.at(run.node_stamps[k]).translation()).norm());
  }
  return worst;
}

/// Squared error of a measurement against the truth, in its own standard deviations.
double squared_sigmas(const RelativeMeasurement& m, const SlamRun& run, const Trajectory& truth) {
  const Pose T_from_to =
      truth.at(run.node_stamps[m.from]).inverse() * truth.at(run.node_stamps[m.to]);
  const Vector6d e = tangent_from_pose(m.T_from_to.inverse() * T_from_to);
  return e.dot(m.information * e);
}

TEST_CASE("wrong loop closures keep to their share and leave the good ones as they were") {
  const Trajectory truth = walk_rounds();
  SlamConfig config;
  const SlamRun good = run_with(truth, config);
  CHECK(good.wrong_closures.empty());
  config.wrong_closures = 0.05;
  const SlamRun run = run_with(truth, config);
  const double share = static_cast<double>(run.wrong_closures.size()) / run.loop_closures;
  CHECK(share == doctest::Approx(0.05).epsilon(0.3));
  CHECK(run.loop_closures == good.loop_closures + static_cast<int>(run.wrong_closures.size()));
  CHECK(run.measurements.size() == good.measurements.size() + run.wrong_closures.size());
}

TEST_CASE("a wrong loop closure that admits its doubt hardly moves the graph") {
  const Trajectory truth = walk_rounds();
  SlamConfig config;
  config.wrong_closures = 0.05;
  const SlamRun run = run_with(truth, config);
  REQUIRE_FALSE(run.wrong_closures.empty());
  for (const RelativeMeasurement& m : run.measurements) CHECK(squared_sigmas(m, run, truth) < 50.0);
  CHECK(worst_node_m(run, truth) < worst_node_m(run_with(truth, SlamConfig{}), truth) + 0.1);
}

TEST_CASE("a confident wrong loop closure claims what is not so, and bends the graph") {
  const Trajectory truth = walk_rounds();
  SlamConfig config;
  config.confident_wrong_closures = 0.05;
  const SlamRun run = run_with(truth, config);
  REQUIRE_FALSE(run.wrong_closures.empty());
  std::size_t far_off = 0;
  for (const RelativeMeasurement& m : run.measurements)
    far_off += squared_sigmas(m, run, truth) > 1e4 ? 1 : 0;
  CHECK(far_off == run.wrong_closures.size());
  CHECK(worst_node_m(run, truth) > 0.5);
  CHECK(worst_node_m(run, truth) < 20.0);
}

TEST_CASE(
    "an unnoticed error stands the old half aside, bends no odometry and hides its closures") {
  constexpr std::size_t kNodes = 100;
  const LateShift shift(1.0, kNodes);
  CHECK(shift.is_unnoticed(79));
  CHECK_FALSE(shift.is_unnoticed(80));
  CHECK_FALSE(LateShift(0.0, kNodes).is_unnoticed(10));
  std::vector<Pose> nodes;
  std::vector<RelativeMeasurement> measurements;
  for (std::size_t k = 0; k < kNodes; ++k) {
    nodes.push_back(make_pose({2.0 * static_cast<double>(k), 0.0, 1.0},
                              Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * static_cast<double>(k),
                                                                   Eigen::Vector3d::UnitZ()))));
    Vector6d noise;
    noise << 0.01, 0.02, -0.01, 0.001, 0.002, 0.003;
    if (k > 0) {
      measurements.push_back({k - 1, k,
                              nodes[k - 1].inverse() * nodes[k] * pose_from_tangent(noise),
                              Information::Identity()});
    }
  }
  const auto closure = [&](std::size_t a, std::size_t b) {
    measurements.push_back({a, b, nodes[a].inverse() * nodes[b], Information::Identity()});
  };
  closure(2, 30);   // within the old half
  closure(5, 70);   // across
  closure(55, 75);  // within the new half

  const FaultyGraph faulty = shift.apply(nodes, measurements);

  for (std::size_t k = 0; k < kNodes; ++k) {
    const double aside = (faulty.T_M_nodes[k].translation() - nodes[k].translation()).norm();
    if (k <= 33) CHECK(aside == doctest::Approx(1.0));
    if (k >= 50) CHECK(aside == 0.0);
  }
  CHECK(faulty.measurements.size() == measurements.size() - 1);
  CHECK(graph_error(faulty.T_M_nodes, faulty.measurements) ==
        doctest::Approx(graph_error(nodes, measurements)));
}

TEST_CASE("late in the mission the published nodes of the old half move by the shift, once") {
  const Trajectory truth = walk_rounds();
  SlamConfig config;
  config.late_shift_m = 1.0;
  const SlamRun run = run_with(truth, config);
  const SlamRun plain = run_with(truth, SlamConfig{});
  const auto first_node = [](const GraphSnapshot& snapshot) {
    return snapshot.g2o.substr(0, snapshot.g2o.find('\n'));
  };
  REQUIRE(run.snapshots.size() == plain.snapshots.size());
  CHECK(run.snapshots.back().g2o == plain.snapshots.back().g2o);
  std::size_t moves = 0;
  for (std::size_t k = 1; k < run.snapshots.size(); ++k) {
    if (first_node(run.snapshots[k]) == first_node(run.snapshots[k - 1])) continue;
    ++moves;
    const double share = static_cast<double>(k) / static_cast<double>(run.snapshots.size());
    CHECK(share == doctest::Approx(0.8).epsilon(0.1));
  }
  CHECK(moves == 1);
}

}  // namespace
}  // namespace cloister
