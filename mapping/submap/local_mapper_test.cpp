#include "mapping/submap/local_mapper.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace cloister {
namespace {

/// Points on the walls of an axis-aligned room, in M.
std::vector<Eigen::Vector3d> room(double x0, double y0, double x1, double y1) {
  std::vector<Eigen::Vector3d> points;
  for (double z = 0; z <= 2.5; z += 0.12) {
    for (double x = x0; x <= x1; x += 0.12) points.insert(points.end(), {{x, y0, z}, {x, y1, z}});
    for (double y = y0; y <= y1; y += 0.12) points.insert(points.end(), {{x0, y, z}, {x1, y, z}});
  }
  return points;
}

struct Fixture {
  explicit Fixture(const Config& config_in = {})
      : config(config_in), store(20'000, 2'000), mapper((config.memory.max_submaps = 8, config), store) {
    mapper.pools().take_all();
    for (Submap& slot : slots) mapper.give_slot(&slot);
  }
  /// One scan of `points_M` from `position_M`, in odometry that agrees with M.
  ScanOutcome scan(const std::vector<Eigen::Vector3d>& points_M, const Eigen::Vector3d& position_M,
                   NodeId node = kNoNode, const Pose& T_N_O = Pose::Identity()) {
    Scan scan;
    scan.kind = Scan::Kind::kCloud;
    scan.stamp = {++clock * 100'000'000};
    for (const Eigen::Vector3d& p : points_M) scan.points_L.push_back((p - position_M).cast<float>());
    Pose T_O_L = Pose::Identity();
    T_O_L.translation() = position_M;
    scan.T_O_L = T_O_L;
    scan.node = node;
    scan.poses = {{scan.stamp, T_N_O * T_O_L}};
    ScanOutcome outcome;
    if (mapper.place(scan, outcome) && mapper.check_spawn(scan, outcome)) mapper.integrate(scan, outcome);
    return outcome;
  }
  /// The same as one turn of a sensor, a column for each point.
  ScanOutcome turn(const std::vector<Eigen::Vector3d>& points_M, const Eigen::Vector3d& position_M) {
    ScanGeometry& geometry = *geometries.emplace_back(std::make_unique<ScanGeometry>());
    geometry.num_beams = 1;
    geometry.num_columns = static_cast<int>(points_M.size());
    geometry.pixel_shift = {0};
    geometry.origin_L.assign(points_M.size(), Eigen::Vector3f::Zero());
    Scan scan;
    scan.geometry = &geometry;
    scan.stamp = {++clock * 100'000'000};
    scan.column_stamps.assign(points_M.size(), scan.stamp);
    scan.column_valid.assign(points_M.size(), 1);
    for (const Eigen::Vector3d& p : points_M) {
      const Eigen::Vector3f p_L = (p - position_M).cast<float>();
      geometry.direction_L.push_back(p_L.normalized());
      scan.ranges_mm.push_back(static_cast<std::uint32_t>(1000 * p_L.norm()));
    }
    Pose T_O_L = Pose::Identity();
    T_O_L.translation() = position_M;
    scan.T_O_L = T_O_L;
    scan.poses = {{scan.stamp, T_O_L}};
    ScanOutcome outcome;
    if (mapper.place(scan, outcome) && mapper.check_spawn(scan, outcome)) mapper.integrate(scan, outcome);
    return outcome;
  }
  Config config;
  std::vector<std::unique_ptr<ScanGeometry>> geometries;
  VoxelStore store;
  LocalMapper mapper;
  std::array<Submap, 8> slots;
  std::int64_t clock = 0;
};

GraphRevision one_node(const Pose& T_M_N) {
  GraphRevision revision;
  revision.graph.nodes = {{0, {100'000'000}, true, T_M_N}};
  revision.T_O_N = {Pose::Identity()};
  return revision;
}

TEST_CASE("the first scan begins the first submap, whose frame lies on the grid") {
  Fixture f;
  const ScanOutcome outcome = f.scan(room(-3, -3, 3, 3), {0.4, 0.2, 1.0});
  CHECK(outcome.spawned == SpawnReason::kFirst);
  CHECK(outcome.submap == 0);
  const Eigen::Vector3d in_blocks = f.mapper.active()->T_M_S.translation() / (8 * 0.065);
  CHECK((in_blocks - in_blocks.array().round().matrix()).norm() < 1e-9);
  CHECK(f.mapper.active()->T_M_S.linear().isIdentity());
}

TEST_CASE("scans of the same room stay in one submap, a scan of another room begins the next") {
  Fixture f;
  const auto first_room = room(-3, -3, 3, 3);
  for (int i = 0; i < 5; ++i) {
    const ScanOutcome outcome = f.scan(first_room, {0.3 * i, 0, 1});
    CHECK(outcome.submap == 0);
    CHECK(outcome.overlap_ratio > 0.95);
  }
  const ScanOutcome outcome = f.scan(room(4, -3, 10, 3), {5, 0, 1});
  CHECK(outcome.spawned == SpawnReason::kOverlap);
  CHECK(outcome.overlap_ratio < 0.6);
  CHECK(outcome.submap == 1);
  REQUIRE(outcome.finished != nullptr);
  CHECK(outcome.finished->id == 0);
}

TEST_CASE("a cloud gathered around a door, which holds both rooms, does not hide the next one") {
  Fixture f;
  const auto first_room = room(-9, -3, 3, 3);
  const auto second_room = room(3, -3, 9, 3);
  auto both_rooms = first_room;
  both_rooms.insert(both_rooms.end(), second_room.begin(), second_room.end());
  CHECK(f.scan(first_room, {-2, 0, 1}).submap == 0);
  CHECK(f.scan(first_room, {0, 0, 1}).submap == 0);
  CHECK(f.scan(both_rooms, {2, 0, 1}).submap == 0);
  CHECK(f.scan(second_room, {4, 0, 1}).spawned == SpawnReason::kOverlap);
}

TEST_CASE("a graph revision bends the active submap at once") {
  Fixture f;
  const GraphRevision before = one_node(Pose::Identity());
  f.mapper.set_graph(&before);
  f.scan(room(-3, -3, 3, 3), {0, 0, 1}, 0);
  const Pose T_M_S = f.mapper.active()->T_M_S;
  Pose moved = Pose::Identity();
  moved.translation() = Eigen::Vector3d(1, 2, 0);
  const GraphRevision after = one_node(moved);
  f.mapper.set_graph(&after);
  CHECK((f.mapper.active()->T_M_S.translation() - T_M_S.translation() - Eigen::Vector3d(1, 2, 0)).norm() < 1e-12);
}

TEST_CASE("a submap that was begun before the first graph is bound to the nearest node") {
  Fixture f;
  f.scan(room(-3, -3, 3, 3), {0, 0, 1});
  CHECK(f.mapper.active()->root == kNoNode);
  const Pose T_O_S = f.mapper.active()->T_M_S;
  Pose T_M_N = Pose::Identity();
  T_M_N.translation() = Eigen::Vector3d(10, 0, 0);
  const GraphRevision revision = one_node(T_M_N);
  f.mapper.set_graph(&revision);
  CHECK(f.mapper.active()->root == 0);
  CHECK((f.mapper.active()->T_M_S.translation() - T_O_S.translation() - Eigen::Vector3d(10, 0, 0)).norm() < 1e-12);
}

TEST_CASE("a correction that moves the present place against the root begins a new submap") {
  Fixture f;
  GraphRevision revision;
  revision.graph.nodes = {{0, {100'000'000}, true, Pose::Identity()}, {1, {300'000'000}, true, Pose::Identity()}};
  revision.T_O_N = {Pose::Identity(), Pose::Identity()};
  f.mapper.set_graph(&revision);
  const auto walls = room(-3, -3, 3, 3);
  f.scan(walls, {0, 0, 1}, 0);
  CHECK(f.scan(walls, {0.1, 0, 1}, 1).spawned == SpawnReason::kNone);
  GraphRevision corrected = revision;
  corrected.graph.nodes[1].T_M_N.translation().x() = 0.3;
  f.mapper.set_graph(&corrected);
  CHECK(f.scan(walls, {0.2, 0, 1}, 1).spawned == SpawnReason::kCorrection);
}

/// Submaps of a walk through rooms of which none is like the one before, a scan and a tenth of a metre each.
std::vector<int> scans_by_submap(double max_threshold_m, int num_scans) {
  Config config;
  config.spawn.cloud_lag_m = 0.4;
  config.spawn.max_threshold_m = max_threshold_m;
  Fixture f(config);
  std::vector<int> num(8);
  for (int i = 0; i < num_scans; ++i) {
    const double away = 1 + 0.7 * i, x = 0.1 * i;
    ++num[f.turn(room(x - away, -away, x + away, away), {x, 0, 1}).submap];
  }
  return num;
}

TEST_CASE("where no scan is at home, the second submap goes on as far as it may") {
  const std::vector<int> chain = scans_by_submap(0, 40);
  REQUIRE(chain[3] > 0);
  const std::vector<int> passed = scans_by_submap(2, 40);
  CHECK(passed[0] == chain[0]);
  CHECK(passed[1] >= 20);
  CHECK(passed[1] <= 20 + chain[1]);
}

TEST_CASE("a submap ends before odometry has drifted far, and what has been seen goes on") {
  Config config;
  config.spawn.cloud_lag_m = 0.4;
  config.spawn.max_travel_m = 2;
  Fixture f(config);
  const auto here = room(-3, -3, 5, 3), elsewhere = room(2, -9, 12, -2);
  for (int i = 0; i <= 45; ++i) {
    CAPTURE(i);
    const ScanOutcome outcome = f.turn(here, {0.1 * i - 2, 0, 1});
    const bool is_end = i > 0 && i % 20 == 0;
    CHECK(outcome.spawned == (i == 0 ? SpawnReason::kFirst : is_end ? SpawnReason::kDistance : SpawnReason::kNone));
    CHECK((outcome.finished != nullptr) == is_end);
    CHECK(outcome.submap == i / 20);
    CHECK(f.mapper.active()->continues == i / 20 - 1);
    CHECK((i == 0 || outcome.overlap_ratio > 0.95));
  }
  // A new cloud would not have told yet that this is another place.
  (void)f.turn(elsewhere, {2.6, 0, 1});
  CHECK(f.turn(elsewhere, {2.7, 0, 1}).spawned == SpawnReason::kOverlap);
  CHECK(f.mapper.active()->continues == kNoSubmap);
}

TEST_CASE("scans without a pose or of an unknown node are refused") {
  Fixture f;
  CHECK(f.scan(room(-3, -3, 3, 3), {0, 0, 1}, 7).refusal == ScanRefusal::kUnknownNode);
  Pose not_a_pose = Pose::Identity();
  not_a_pose.translation().x() = std::nan("");
  CHECK(f.scan(room(-3, -3, 3, 3), {0, 0, 1}, kNoNode, not_a_pose).refusal == ScanRefusal::kNoPose);
  Pose diverged = Pose::Identity();
  diverged.translation().x() = 1e300;
  const GraphRevision revision = one_node(diverged);
  f.mapper.set_graph(&revision);
  CHECK(f.scan(room(-3, -3, 3, 3), {0, 0, 1}, 0).refusal == ScanRefusal::kNoPose);
  CHECK(f.mapper.num_spawned() == 0);
}

TEST_CASE("without a slot the mapper goes on in the old submap") {
  Fixture f;
  for (int i = 0; i < 10; ++i) {
    const double x = 20.0 * i;
    const ScanOutcome outcome = f.scan(room(x, -3, x + 6, 3), {x + 3, 0, 1});
    CHECK(outcome.submap == std::min(i, 7));
    CHECK(outcome.refusal == ScanRefusal::kNone);
    CHECK(outcome.is_spawn_declined == (i > 7));
  }
}

TEST_CASE("in baseline mode submaps are spawned by distance alone") {
  Config config;
  config.baseline = true;
  config.spawn.baseline_distance_m = 1.0;
  Fixture f(config);
  const auto walls = room(-3, -3, 3, 3);
  int num_spawned = 0;
  for (int i = 0; i < 12; ++i) num_spawned += f.scan(walls, {-2.5 + 0.25 * i, 0, 1}).spawned != SpawnReason::kNone;
  CHECK(num_spawned == 3);
}

}  // namespace
}  // namespace cloister
