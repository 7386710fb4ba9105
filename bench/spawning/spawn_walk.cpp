#include "bench/spawning/spawn_walk.hpp"

#include <algorithm>
#include <limits>

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr std::size_t kBlocks = 200'000;
constexpr std::size_t kChunks = 20'000;

ScanGeometry geometry_of(const SensorModel& sensor) {
  const BeamFan fan = make_beam_fan(sensor);
  const auto beams = static_cast<std::size_t>(sensor.beams());
  ScanGeometry geometry;
  geometry.num_beams = sensor.beams();
  geometry.num_columns = sensor.columns;
  geometry.pixel_shift = sensor.pixel_shift();
  for (std::size_t beam = 0; beam < beams; ++beam) {
    for (std::size_t column = 0; column < fan.origins_L.size(); ++column) {
      const Eigen::Vector3f& direction_L = fan.directions_L[column * beams + beam];
      geometry.direction_L.push_back(direction_L);
      // Ranges count from the spin axis, beams leave beside it.
      geometry.origin_L.emplace_back(
          fan.origins_L[column] - static_cast<float>(sensor.beam_origin_mm * 1e-3) * direction_L);
    }
  }
  geometry.projection = fit_projection(geometry.num_beams, geometry.num_columns,
                                       geometry.direction_L, geometry.origin_L);
  return geometry;
}

Config with_slots(Config config, int max_submaps) {
  config.memory.max_submaps = max_submaps;
  return config;
}

}  // namespace

SpawnWalk::SpawnWalk(const SensorModel& sensor, const Config& config)
    : sensor_(sensor),
      config_(with_slots(config, kMaxSubmaps)),
      geometry_(geometry_of(sensor)),
      store_(kBlocks, kChunks),
      mapper_(config_, store_),
      pixels_(geometry_.direction_L.size()) {
  mapper_.pools().take_all();
  for (Submap& slot : slots_) mapper_.give_slot(&slot);
  scan_.geometry = &geometry_;
  scan_.ranges_mm.resize(pixels_.size());
  scan_.column_stamps.resize(static_cast<std::size_t>(sensor.columns));
  scan_.column_valid.assign(static_cast<std::size_t>(sensor.columns), 1);
}

void SpawnWalk::scan(const TriangleMesh& mesh_W, const RayScene& scene_W, const Trajectory& truth,
                     std::uint64_t k) {
  const ScanSimulator simulator(sensor_, mesh_W, scene_W, 1);
  simulator.simulate(truth, truth.start, k, pixels_);
  const auto beams = static_cast<std::size_t>(sensor_.beams());
  const auto columns = static_cast<std::size_t>(sensor_.columns);
  scan_.poses.clear();
  for (std::size_t column = 0; column < columns; ++column) {
    const SensorTime stamp = simulator.column_stamp(truth.start, k, static_cast<int>(column));
    scan_.column_stamps[column] = stamp;
    if (column % 16 == 0 || column + 1 == columns) scan_.poses.push_back({stamp, truth.at(stamp)});
    for (std::size_t beam = 0; beam < beams; ++beam)
      scan_.ranges_mm[beam * columns + column] = pixels_[column * beams + beam].range_mm;
  }
  scan_.index = k;
  scan_.stamp = scan_.last_packet = scan_.column_stamps.back();
  const Pose T_W_L = scan_.poses.back().T_R_L;
  if (scan_.T_O_L) travel_m_ += (scan_.T_O_L->translation() - T_W_L.translation()).norm();
  scan_.T_O_L = T_W_L;

  ScanOutcome outcome;
  REQUIRE(mapper_.place(scan_, outcome));
  REQUIRE(mapper_.check_spawn(scan_, outcome));
  mapper_.integrate(scan_, outcome);
  REQUIRE(outcome.voxels_declined == 0);
  REQUIRE_FALSE(outcome.is_spawn_declined);
  if (outcome.spawned != SpawnReason::kNone && outcome.spawned != SpawnReason::kDistance)
    submaps_.push_back({outcome.spawned, travel_m_});
}

void SpawnWalk::scan_all(const TriangleMesh& mesh_W, const Trajectory& truth) {
  const auto scene_W = RayScene::build(mesh_W);
  REQUIRE(scene_W.has_value());
  const double seconds = (truth.end() - truth.start).seconds();
  const auto num_scans = static_cast<std::uint64_t>(seconds * sensor_.rate_hz);
  for (std::uint64_t k = 0; k < num_scans; ++k) scan(mesh_W, *scene_W, truth, k);
}

double SpawnWalk::shortest_submap_m() const {
  double shortest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < submaps_.size(); ++k)
    shortest_m = std::min(shortest_m, submaps_[k].begins_at_m - submaps_[k - 1].begins_at_m);
  return shortest_m;
}

}  // namespace cloister
