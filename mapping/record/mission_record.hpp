#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/submap/submap.hpp"

namespace cloister {

/// One line of timeline.csv: what happened to one scan.
struct TimelineRow {
  SensorTime stamp;
  SubmapId submap =
      kNoSubmap;           ///< the submap it went to when it was integrated (before later fusions)
  float integrate_ms = 0;  ///< wall time from a complete scan to its last voxel, deskew included
  float integration_cpu_ms = 0;  ///< CPU time of the thread over the same stretch
  float latency_ms = 0;    ///< wall time from the scan's last packet to its last voxel
  std::int32_t submaps = 0;       ///< how many exist after this scan
  std::int64_t map_bytes = 0;     ///< memory of all submaps after this scan
  std::int32_t queue_depth = 0;   ///< scans that waited when this one was taken
  float overlap_ratio = 0;        ///< R_point against the active submap's cloud
  Pose T_M_L = Pose::Identity();  ///< where the sensor was, by the graph of that moment
};

enum class EventKind {
  kSpawn,
  kLoopClosure,
  kOverlapChecked,
  kFusionAccepted,
  kFusionRejected,
  kGraphUpdated,
  kSpill,
  kReload,
  kDegrade,
  kDrop,
};

/// One line of events.jsonl: a decision and the numbers it was taken by. Fields that do not apply
/// are left out.
struct Event {
  EventKind kind = EventKind::kSpawn;
  SensorTime stamp = {};
  std::string reason = {};  ///< why, in a word: "overlap", "correction", "loop", "uncertainty", ...
  SubmapId a = kNoSubmap;  ///< the submap spawned, or the first of a pair
  SubmapId b = kNoSubmap;
  double ratio_a = -1;  ///< overlap ratio over a's known voxels; R_point for a spawn; < 0: none
  double ratio_b = -1;
  std::array<double, 3> sigma_m = {
      -1, -1, -1};          ///< translational standard deviations, ascending; < 0: none
  NodeId node_a = kNoNode;  ///< root of a, or a loop closure's ends
  NodeId node_b = kNoNode;
  std::int64_t count = -1;  ///< e.g. nodes of a graph update, voxels declined; < 0: none
  double shift_m = -1;      ///< how far surfaces laid a fused pair from the graph's word; < 0: none
};

/// Median, percentiles and maximum of a set of durations in milliseconds; zeros when there were
/// none.
struct TimingSummary {
  double p50 = 0, p95 = 0, p99 = 0, p999 = 0, max = 0;
};

/// The summary of some durations in any order. A percentile between two of them is interpolated
/// linearly (numpy's default, so that a reader of timeline.csv gets the same numbers); entries that
/// are not finite are left out.
[[nodiscard]] TimingSummary summarise(std::vector<float> durations_ms);

/// A submap as the mission left it, without its voxels.
struct SubmapRecord {
  SubmapId id = kNoSubmap;
  std::vector<SubmapId> merged_from;
  NodeId root = kNoNode;
  Pose T_M_S = Pose::Identity();
  Eigen::Vector3d aabb_min_M = Eigen::Vector3d::Zero();  ///< of its known voxels, in M
  Eigen::Vector3d aabb_max_M = Eigen::Vector3d::Zero();
  std::vector<NodeId> nodes;
  std::vector<SensorTime> scan_stamps;
  std::int64_t blocks = 0;
  std::int64_t bytes = 0;
  double observed_m3 = 0;
  /// Centres of occupied voxels in M (metres), at every height, for the report's plan: it is drawn in
  /// cells of a voxel, so that thinned points would make dotted walls.
  std::vector<Eigen::Vector3f> surface_M;
};

/// Everything that replay and run leave in OUT beside the voxels and meshes. Filled by the
/// pipeline, written by firmware_interface/output. Counters follow the keys of summary.json.
struct MissionRecord {
  Config config;
  std::string mission;                ///< name for the report's title
  std::vector<TimelineRow> timeline;  ///< in the order of integration
  std::vector<Event> events;          ///< in the order of stamps
  std::vector<SubmapRecord> submaps;  ///< final, ascending id
  std::vector<std::pair<SensorTime, Pose>>
      path_M;  ///< final pose of every integrated scan, by the last graph

  std::int64_t scans_read = 0, scans_integrated = 0, scans_dropped = 0, returns_integrated = 0;
  double duration_s = 0, travel_m = 0;
  std::int64_t submaps_spawned = 0, submaps_fused = 0, submaps_final = 0, submaps_peak = 0;
  double observed_m3 = 0;
  std::int64_t fusions_proposed_by_loop = 0, fusions_proposed_by_overlap = 0, fusions_accepted = 0,
               fusions_rejected_by_uncertainty = 0, fusions_rejected_by_overlap = 0;
  std::int64_t budget_bytes = 0, map_bytes_peak = 0, map_bytes_final = 0, spilled_bytes = 0,
               rss_peak_bytes = 0;
  std::int64_t cloud_bytes = 0;  ///< submap clouds, beside map_bytes, never in it
  std::vector<float> overlap_ms, fuse_ms, uncertainty_ms;  ///< one entry a call
  double cpu_decode_s = 0, cpu_spawn_check_s = 0, cpu_integration_s = 0, cpu_overlap_s = 0,
         cpu_uncertainty_s = 0, cpu_fusion_s = 0, cpu_total_s = 0;
  std::map<std::string, std::int64_t> drops;  ///< cause -> count
  std::map<std::string, std::int64_t>
      counters;  ///< further counts worth reporting (queue high-water marks, ...)
  std::vector<std::string> warnings;  ///< one line each, also printed on stderr
  std::uint64_t map_hash = 0;
  bool interrupted = false;
};

}  // namespace cloister
