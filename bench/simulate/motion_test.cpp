#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "bench/simulate/odometry.hpp"
#include "bench/simulate/path_file.hpp"
#include "bench/simulate/slam_standin.hpp"
#include "bench/simulate/walk.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

constexpr SensorTime kStart{1'700'000'000'250'000'000};

/// A square walked `laps` times.
std::vector<Waypoint> square(double edge, int laps) {
  std::vector<Waypoint> path = {{{0.0, 0.0, 1.0}, 0.0}};
  for (int lap = 0; lap < laps; ++lap) {
    path.push_back({{edge, 0.0, 1.0}, 0.0});
    path.push_back({{edge, edge, 1.0}, 0.5});
    path.push_back({{0.0, edge, 1.0}, 0.0});
    path.push_back({{0.0, 0.0, 1.0}, 0.0});
  }
  return path;
}

TEST_CASE("a walk stands still at both ends and looks where it goes") {
  WalkConfig config;
  config.shake_m = config.shake_rad = 0.0;
  const Trajectory truth =
      walk(std::vector<Waypoint>{{{0, 0, 1}, 0.0}, {{0, 8, 1}, 0.0}}, config, kStart, 1);
  CHECK((truth.poses.front().translation() - Eigen::Vector3d(0, 0, 1)).norm() < 0.02);
  CHECK((truth.poses.back().translation() - Eigen::Vector3d(0, 8, 1)).norm() < 0.02);
  CHECK((truth.poses[0].translation() - truth.poses[60].translation()).norm() < 1e-6);
  for (const Pose& pose : truth.poses) CHECK(pose.linear().col(0).y() > 0.999);
}

TEST_CASE("odometry without drift is the truth seen from its first pose") {
  const Trajectory truth = walk(square(5.0, 1), WalkConfig{}, kStart, 1);
  DriftConfig none;
  none.percent = 0.0;
  const Trajectory odometry = corrupt(truth, none, 1);
  CHECK(odometry.poses[0].isApprox(Pose::Identity(), 1e-12));
  for (std::size_t k = 0; k < truth.poses.size(); k += 50) {
    CHECK((truth.poses[0].inverse() * truth.poses[k]).isApprox(odometry.poses[k], 1e-9));
  }
}

TEST_CASE("odometry drifts by about the stated share of 20 m walked") {
  double sum = 0.0;
  constexpr int kRuns = 60;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const Trajectory truth = walk(std::vector<Waypoint>{{{0, 0, 1}, 0.0}, {{20, 0, 1}, 0.0}},
                                  WalkConfig{}, kStart, seed);
    const Trajectory odometry = corrupt(truth, DriftConfig{}, seed);
    const Pose moved = truth.poses.front().inverse() * truth.poses.back();
    sum += (odometry.poses.back().translation() - moved.translation()).squaredNorm();
  }
  const double percent = 100.0 * std::sqrt(sum / kRuns) / 20.0;
  CHECK(percent > 0.35);
  CHECK(percent < 0.75);
}

TEST_CASE("loop closures keep the graph nearer to the truth than odometry alone") {
  const Trajectory truth = walk(square(12.0, 3), WalkConfig{}, kStart, 4);
  DriftConfig drift;
  drift.percent = 1.5;
  const Trajectory odometry = corrupt(truth, drift, 4);
  const auto in_sight = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return true; };
  const auto blind = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return false; };
  const SlamRun closed = run_slam(truth, odometry, drift, SlamConfig{}, in_sight, 4);
  const SlamRun open = run_slam(truth, odometry, drift, SlamConfig{}, blind, 4);

  CHECK(closed.loop_closures > 5);
  CHECK(open.loop_closures == 0);
  const auto mean_error = [&](const SlamRun& run) {
    double sum = 0.0;
    for (std::size_t k = 0; k < run.T_M_nodes.size(); ++k) {
      sum += (run.T_M_nodes[k].translation() - truth.at(run.node_stamps[k]).translation()).norm();
    }
    return sum / static_cast<double>(run.T_M_nodes.size());
  };
  CHECK(mean_error(closed) < 0.5 * mean_error(open));
  for (const RelativeMeasurement& m : closed.measurements)
    CHECK((m.to == m.from + 1 || m.to > m.from + 15));
}

TEST_CASE(
    "nodes are two metres of travel apart and the first is published at once, where it truly is") {
  const Trajectory truth = walk(square(6.0, 2), WalkConfig{}, kStart, 1);
  const Trajectory odometry = corrupt(truth, DriftConfig{}, 1);
  const SlamRun run = run_slam(
      truth, odometry, DriftConfig{}, SlamConfig{},
      [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return true; }, 1);
  CHECK(run.T_M_nodes[0].isApprox(truth.poses[0]));
  REQUIRE(run.snapshots.size() > 5);
  CHECK(run.snapshots[0].stamp.ns == kStart.ns + 150'000'000);
  CHECK(run.snapshots[0].g2o.starts_with("VERTEX_SE3:QUAT_TIME 0 "));
  CHECK(run.snapshots[0].g2o.ends_with(" 1700000000 250000000\n"));
  for (std::size_t k = 1; k < run.node_stamps.size(); ++k) {
    const auto first =
        static_cast<std::size_t>((run.node_stamps[k - 1] - kStart).ns / truth.step.ns);
    const auto last = static_cast<std::size_t>((run.node_stamps[k] - kStart).ns / truth.step.ns);
    double length = 0.0;
    for (std::size_t n = first + 1; n <= last; ++n) {
      length += (truth.poses[n].translation() - truth.poses[n - 1].translation()).norm();
    }
    CHECK(length >= 2.0);
    CHECK(length < 2.03);
  }
}

TEST_CASE("a trajectory survives being written and read, to the nanosecond") {
  Trajectory trajectory =
      walk(square(3.0, 1), WalkConfig{}, SensorTime{1'700'000'000'123'456'789}, 1);
  trajectory.poses.resize(300);
  const fs::path path =
      fs::temp_directory_path() / ("cloister-motion-test-" + std::to_string(getpid()) + ".tum");
  std::ofstream(path) << "# t x y z qx qy qz qw\n" << format_tum(trajectory);
  const auto back = read_tum(path);
  REQUIRE(back);
  REQUIRE(back->size() == trajectory.poses.size());
  for (std::size_t k = 0; k < back->size(); ++k) {
    CHECK((*back)[k].stamp == trajectory.stamp(k));
    CHECK((*back)[k].pose.translation() == trajectory.poses[k].translation());
    CHECK((*back)[k].pose.isApprox(trajectory.poses[k], 1e-14));
  }
  fs::remove(path);
}

TEST_CASE("a path file is walked through or replayed, by what its lines hold") {
  const fs::path path =
      fs::temp_directory_path() / ("cloister-motion-test-" + std::to_string(getpid()) + "path.txt");
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_path(path, WalkConfig{}, kStart, 1);
  };
  const auto walked = read("# places\n0 0 1\n4 0 1 0.5\n4 3 1\n");
  REQUIRE(walked);
  CHECK((walked->poses.back().translation() - Eigen::Vector3d(4, 3, 1)).norm() < 0.05);
  const auto replayed = read("10.0 1 2 3 0 0 0 1\n11.5 2 2 3 0 0 0 1\n");
  REQUIRE(replayed);
  CHECK(replayed->start == kStart);
  CHECK(replayed->poses.size() == 151);
  CHECK(replayed->poses[75].translation().isApprox(Eigen::Vector3d(1.5, 2, 3)));
  for (const auto* text :
       {"", "0 0 1\n", "0 0 1\n0 0\n", "0 0 1\nx 0 1\n", "0 0 1\n0 0 1\n", "1 1 2 3 0 0 0 0\n"}) {
    CAPTURE(text);
    const auto bad = read(text);
    REQUIRE_FALSE(bad);
    CHECK(bad.error().kind == ErrorKind::kInput);
  }
  CHECK(read("0 0 1\nx 0 1\n").error().message.find("path.txt:2:") != std::string::npos);
  fs::remove(path);
}

}  // namespace
}  // namespace cloister
