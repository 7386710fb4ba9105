#pragma once

#include <cmath>
#include <random>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// A made-up mission for tests of the outputs: a house of two storeys, each of three rooms in a row
/// of 5 x 6 m with doors between them and stairs at the east end; one submap a room, walked twice;
/// 500 scans, events of every kind.
inline MissionRecord make_test_mission() {
  constexpr double kStorey_m = 2.9, kRoom_m = 5.0, kDepth_m = 6.0, kStep_m = 0.065, kSensor_m = 1.1;
  MissionRecord r;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  const SensorTime begin{1'650'000'000'123'456'789};
  const auto at = [&](double t_s) { return begin + Duration::from_seconds(t_s); };

  r.mission = "two storeys & <six> rooms";
  for (SubmapId id = 0; id < 6; ++id) {
    SubmapRecord submap;
    const double floor = id < 3 ? 0.0 : kStorey_m;
    const double x0 = kRoom_m * (id < 3 ? id : 5 - id);
    submap.id = id;
    if (id == 2) submap.merged_from = {7, 9};
    submap.root = 10 * id;
    submap.T_M_S =
        make_pose({x0 + 0.1 / 3, 1.0 / 3, floor}, Eigen::Quaterniond(1, 0.001, -0.002, 0.3 * id));
    submap.aabb_min_M = {x0, 0, floor};
    submap.aabb_max_M = {x0 + kRoom_m, kDepth_m, floor + 2.6};
    for (NodeId n = 0; n < 10; ++n) submap.nodes.push_back(10 * id + n);
    for (int k = 0; k < 80; ++k) submap.scan_stamps.push_back(at(id * 8 + 0.1 * k));
    submap.blocks = 900 + 10 * id;
    submap.bytes = 700'000 + 1'000 * id;
    submap.observed_m3 = kRoom_m * kDepth_m * 2.6;
    const auto add = [&](double x, double y, double z) {
      submap.surface_M.emplace_back(static_cast<float>(x), static_cast<float>(y),
                                    static_cast<float>(z));
    };
    const auto is_seen = [&] { return random() % 10 != 0; };
    for (double u = 0; u <= kRoom_m; u += kStep_m) {
      for (double v = 0; v <= kDepth_m; v += kStep_m) {
        if (is_seen()) add(x0 + u, v, floor);
        if (is_seen()) add(x0 + u, v, floor + 2.6);
      }
      for (double h = 0.1; h < 2.6; h += kStep_m) {
        if (is_seen()) add(x0 + u, 0.0, floor + h);
        if (is_seen()) add(x0 + u, kDepth_m, floor + h);
        if (h < 0.75 && u > 1.2 && u < 2.5) add(x0 + u, 4.4, floor + h);  // a sideboard
      }
    }
    for (double v = 0; v <= kDepth_m; v += kStep_m) {
      const bool is_door = v > 2.4 && v < 3.4;
      for (double h = 0.1; h < 2.6; h += kStep_m) {
        if (!is_door || x0 == 0.0) add(x0, v, floor + h);
        if (!is_door || x0 == 2 * kRoom_m) add(x0 + kRoom_m, v, floor + h);
      }
    }
    r.submaps.push_back(std::move(submap));
  }

  // East through the lower rooms, up the stairs, west through the upper ones, and back: twice.
  const std::vector<Eigen::Vector3d> corners = {
      {1.0, 1.5, 0},          {3.8, 1.5, 0},          {3.8, 2.9, 0},         {7.5, 2.9, 0},
      {7.0, 5.0, 0},          {8.5, 2.9, 0},          {13.9, 2.9, 0},        {13.9, 0.9, 0},
      {10.7, 0.9, kStorey_m}, {10.7, 2.9, kStorey_m}, {7.5, 2.9, kStorey_m}, {7.5, 1.2, kStorey_m},
      {6.0, 2.9, kStorey_m},  {2.0, 2.9, kStorey_m},  {2.0, 4.8, kStorey_m}, {3.5, 2.9, kStorey_m},
      {10.7, 2.7, kStorey_m}, {10.7, 1.1, kStorey_m}, {13.9, 1.1, 0},        {13.9, 2.7, 0},
      {1.0, 2.7, 0},          {1.0, 1.5, 0}};
  double length_m = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) length_m += (corners[i] - corners[i - 1]).norm();
  constexpr int kScans = 500;
  for (int k = 0; k < kScans; ++k) {
    double rest_m = std::fmod(2 * length_m * k / kScans, length_m);
    std::size_t leg = 1;
    while (rest_m > (corners[leg] - corners[leg - 1]).norm())
      rest_m -= (corners[leg] - corners[leg - 1]).norm(), ++leg;
    const Eigen::Vector3d along = (corners[leg] - corners[leg - 1]).normalized();
    const Eigen::Vector3d p_M = corners[leg - 1] + rest_m * along +
                                Eigen::Vector3d(0.03 * noise(random), 0.03 * noise(random),
                                                kSensor_m + 0.02 * noise(random));
    r.path_M.emplace_back(
        at(0.1 * k),
        make_pose(p_M, Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(along.y(), along.x()),
                                                            Eigen::Vector3d::UnitZ()))));
    TimelineRow row;
    row.stamp = at(0.1 * k);
    row.submap = static_cast<SubmapId>(p_M.z() > 2.5 ? 5 - p_M.x() / kRoom_m : p_M.x() / kRoom_m);
    row.integrate_ms = static_cast<float>(22 * std::exp(0.25 * noise(random)));
    row.integration_cpu_ms = 0.9f * row.integrate_ms;
    row.latency_ms = row.integrate_ms + static_cast<float>(9 * std::exp(0.5 * noise(random)));
    row.submaps = 1 + std::min(k, 300) / 40 - (k > 250) - (k > 330);
    row.map_bytes = 4'000'000 + 60'000 * std::min(k, 250) + 2'000 * k - (k > 330 ? 3'000'000 : 0);
    row.overlap_ratio = static_cast<float>(0.5 + 0.4 * std::abs(std::sin(0.03 * k)));
    row.T_M_L = r.path_M.back().second;
    r.timeline.push_back(row);
  }

  for (SubmapId id = 0; id < 8; ++id) {
    r.events.push_back({EventKind::kSpawn,
                        at(4.0 * id),
                        "overlap",
                        id,
                        kNoSubmap,
                        0.55 - 0.01 * id,
                        -1,
                        {-1, -1, -1},
                        10 * id});
  }
  r.events.push_back({EventKind::kGraphUpdated,
                      at(33),
                      "",
                      kNoSubmap,
                      kNoSubmap,
                      -1,
                      -1,
                      {-1, -1, -1},
                      kNoNode,
                      kNoNode,
                      71});
  r.events.push_back({EventKind::kLoopClosure, at(33), "", 2, 7, -1, -1, {-1, -1, -1}, 21, 70});
  r.events.push_back({EventKind::kOverlapChecked,
                      at(33),
                      "loop",
                      2,
                      7,
                      0.81,
                      0.1 + 0.2,
                      {0.011, 0.012, 0.031},
                      20,
                      70});
  r.events.push_back({EventKind::kFusionAccepted,
                      at(33),
                      "loop",
                      2,
                      7,
                      0.81,
                      0.1 + 0.2,
                      {0.011, 0.012, 0.031},
                      20,
                      70});
  r.events.back().shift_m = 0.08;
  r.events.push_back(
      {EventKind::kOverlapChecked, at(33), "box", 3, 6, std::nan(""), 0.02, {-1, -1, -1}, 30, 60});
  r.events.push_back({EventKind::kFusionRejected,
                      at(34),
                      "uncertainty",
                      4,
                      5,
                      0.72,
                      0.64,
                      {0.05, 0.11, 0.27},
                      40,
                      50});
  r.events.push_back({EventKind::kSpill,
                      at(35),
                      "budget",
                      1,
                      kNoSubmap,
                      -1,
                      -1,
                      {-1, -1, -1},
                      kNoNode,
                      kNoNode,
                      7000});
  r.events.push_back({EventKind::kReload, at(36), "revisited", 1});
  r.events.push_back({EventKind::kDegrade,
                      at(37),
                      "blocks exhausted",
                      1,
                      kNoSubmap,
                      -1,
                      -1,
                      {-1, -1, -1},
                      kNoNode,
                      kNoNode,
                      123});
  r.events.push_back({EventKind::kDrop,
                      at(38),
                      "no pose",
                      kNoSubmap,
                      kNoSubmap,
                      -1,
                      -1,
                      {-1, -1, -1},
                      kNoNode,
                      kNoNode,
                      1});

  r.scans_read = 503, r.scans_integrated = kScans, r.scans_dropped = 3,
  r.returns_integrated = 24'123'456;
  r.duration_s = 0.1 * (kScans - 1), r.travel_m = 2 * length_m;
  r.submaps_spawned = 8, r.submaps_fused = 2, r.submaps_final = 6, r.submaps_peak = 7;
  r.observed_m3 = 468.25;
  r.fusions_proposed_by_loop = 3, r.fusions_proposed_by_overlap = 5, r.fusions_accepted = 2;
  r.fusions_rejected_by_uncertainty = 1, r.fusions_rejected_by_overlap = 5;
  r.budget_bytes = 64'000'000, r.map_bytes_peak = 19'900'000, r.map_bytes_final = 17'400'000;
  r.spilled_bytes = 7'000, r.rss_peak_bytes = 181'000'000, r.cloud_bytes = 512'000;
  r.config.memory.budget_bytes = r.budget_bytes;
  r.overlap_ms = {1.5f, 0.1f, 7.25f}, r.fuse_ms = {41.0f, 55.5f}, r.uncertainty_ms = {0.6f};
  r.cpu_decode_s = 1.25, r.cpu_spawn_check_s = 0.9, r.cpu_integration_s = 12.1,
  r.cpu_overlap_s = 0.01;
  r.cpu_uncertainty_s = 0.002, r.cpu_fusion_s = 0.1, r.cpu_total_s = 15.3;
  r.drops = {{"no_pose", 2}, {"queue_full", 1}};
  r.counters = {{"scan_queue_high_water", 3}, {"packets", 64'000}};
  r.warnings = {"lidar.pcap: ends inside packet 64001; read up to there",
                "metadata.json: no \"serial\""};
  r.map_hash = 0x00ab'cdef'0123'4567;
  return r;
}

}  // namespace cloister
