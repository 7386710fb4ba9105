#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace cloister {

/// Log-odds occupancy and its grid.
///
/// A surface lies as often before its returns as behind them. Where it runs along the border of two layers of voxels, the
/// nearer one would be hit by half of the returns and never be cleared; so the surface is looked for a little behind them,
/// at about twice the noise of their ranges, where no beam passes.
struct VoxelConfig {
  double voxel_size_m = 0.065;
  double min_range_m = 0.5;
  double max_range_m = 60.0;
  double return_depth_m = 0.025;  ///< how far behind a return, along its beam, its surface is marked
  double log_odds_hit = 0.85;
  double log_odds_miss = -0.4;
  double log_odds_min = -2.0;
  double log_odds_max = 3.5;
};

/// When a new submap begins (paper, section III-A).
///
/// The paper's R_point is at most 0.6, between scans of nodes that lie metres apart. Every scan is asked here, and through
/// three doors in one line the least that a walk comes down to is 0.60 to 0.68: at 0.65 nearly every door is noticed. A
/// submap too many costs little, for it is fused again; one that holds two rooms is never parted.
///
/// Against somebody who passes right before the sensor and hides half a room: two scans in a row must agree. Against chains
/// of tiny submaps there are two rules. The first: a scan is held against a submap's cloud only once that cloud holds
/// four scans. Scans join it `cloud_lag_m` late and an eighth of that apart, so no overlap ends a submap within five
/// fourths of `cloud_lag_m`, 2.5 m. The way counts, not the time: who stands still or turns on the spot waits for ever.
///
/// The second: where a gateway opens into a wider place, even then no scan may be at home in a new submap, nor in the one
/// after it. If the overlap has fallen far below the limit, that one goes on: the next scans are held against a new cloud, until one
/// is at home there or the submap is `max_threshold_m` long.
///
/// A submap is rigid, odometry is not: at 0.5 % it drifts half a voxel within `max_travel_m`. So a submap ends there, however
/// much of it is still in sight, and scans go on in the next, which is fused with it. Each is laid on what is known of its
/// place by its surfaces, and joins it. Who comes back to a known place begins a submap all the same, for what the sensor sees from
/// the door tells little, and no scan goes into a fused submap: drift would shift its walls, and whatever came later be laid
/// on those.
struct SpawnConfig {
  double min_overlap = 0.65;     ///< R_point at or below which a scan starts a new submap
  int min_scans = 2;             ///< so many scans in a row, at least; clouds that stand alone need no second
  double filter_m = 0.25;        ///< r_filter: edge of the voxel filter of scan and submap cloud
  double cloud_lag_m = 2.0;      ///< a scan joins its submap's cloud once the sensor has moved this far from it
  double max_threshold_m = 10.0; ///< how far a submap goes on in which, as in the one before, no scan is at home
  double max_travel_m = 7.0;     ///< a submap ends where odometry has drifted so far as to blur it; 0: never
  double min_covisibility = 0.5; ///< share of a submap's scans that must see a place for it to count as part of it
  double max_correction_m = 0.065;  ///< a graph correction that shifts the present place further starts a new submap
  double baseline_distance_m = 10.0;  ///< distance travelled per submap in baseline mode
};

/// When two submaps become one (paper, sections III-B and III-C).
///
/// From its doorway a room of 4 m is seen to nine tenths: the overlap alone would join every room with the next. So the
/// two paths must see each other as well, and not only through a door.
struct FusionConfig {
  double min_overlap = 0.7;      ///< lambda_fusion: larger of both voxel overlap ratios, for submaps of one place
  double min_shared_sight = 0.7; ///< one place: share of lines between the paths, and places beside them, that are clear
  double max_sigma_m = 0.2;           ///< largest translational standard deviation between two roots
  double max_sigma_unlooped_m = 0.2;  ///< the same for pairs that no loop closure's range covers
  bool fuse_without_covariance = false;  ///< what to do while the graph has no edges, so that it tells no uncertainty
  double default_information = 0.0;   ///< stands in for missing information matrices (1/m^2, 1/rad^2); 0 = refuse them
};

/// Longest range in voxels: the table of chunks around the sensor grows with its third power (126 MB here).
inline constexpr double kMaxRangeVoxels = 10'000;

/// Upper bound of what one submap takes beside its voxels.
inline constexpr std::int64_t kMaxSubmapSlotBytes = 12'288;

/// All memory the map may ever take, and how it is divided.
struct MemoryConfig {
  std::int64_t budget_bytes = 1024LL << 20;  ///< voxel blocks, indices and bookkeeping of all submaps
  int max_submaps = 2048;
  std::int64_t max_cloud_points = 1'000'000;  ///< filtered points of the active submap's cloud
};

/// What is done to a scan before it is integrated.
struct ScanConfig {
  int max_points = 262'144;
  double max_odometry_gap_s = 1.0;   ///< no pose is interpolated across a longer gap
  double max_odometry_wait_s = 0.5;  ///< how long past its stamp a scan may wait for its pose, and be extrapolated
  double stamp_offset_s = 0.0;       ///< added to every lidar stamp before poses are looked up
};

/// Everything that can be set from a file or with --set; see runtime/config_file.hpp for the loader.
struct Config {
  VoxelConfig voxel;
  SpawnConfig spawn;
  FusionConfig fusion;
  MemoryConfig memory;
  ScanConfig scan;
  bool baseline = false;  ///< spawn by distance, fuse at loop closures only, no uncertainty check
};

/// The first thing that is wrong with a configuration, as "field = value: bound", or nothing.
[[nodiscard]] std::optional<std::string> validate(const Config& config);

}  // namespace cloister
