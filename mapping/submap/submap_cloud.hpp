#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/config.hpp"
#include "mapping/scan/scan_beams.hpp"
#include "mapping/submap/covisibility_grid.hpp"
#include "mapping/submap/point_grid.hpp"

namespace cloister {

/// The accumulated, voxel-filtered cloud of the active submap, and how much of a scan it already contains
/// (paper, section III-A, "cloud overlap estimate").
///
/// A scan joins the cloud only when the sensor has moved `cloud_lag_m` on: scans follow each other every few
/// centimetres, and one compared with a cloud that holds its direct predecessor would always overlap. The lag stands
/// for the distance between graph nodes in the paper, but does not depend on where the nodes happen to lie: every
/// doorway is judged alike. Clouds of one a node lie as far apart, and are compared before `advance`, so that each waits for
/// the next: what a robot gathers between two nodes around a door holds both rooms, and its successor would never be of
/// another place.
///
/// Of the cloud, only what is established counts (see CovisibilityGrid): through an open door a sensor sees most of
/// the next room bit by bit long before it goes there, and no overlap would ever fall.
///
/// A cloud of very few scans is no measure of a place: among leaves, and among people who walk about, two scans from one
/// place share less than two thirds. So a submap lasts until its cloud holds as many scans as `established` asks for:
/// five fourths of the lag and some centimetres.
///
/// Threads: one owner. Real-time: no allocation after construction.
class SubmapCloud {
 public:
  SubmapCloud(const SpawnConfig& config, std::size_t max_points);

  /// Voxel-filters the returns of a scan; what follows refers to them.
  /// @param T_C_S  takes the scan's frame to the cloud's
  void filter(const ScanBeams& scan, const Eigen::Isometry3f& T_C_S);
  /// R_point: share of the filtered scan's points that lie where the cloud is established, with its nearest point closer
  /// than sqrt(3) x filter.
  /// 1 for a scan without points: it cannot ask for a new submap.
  [[nodiscard]] double overlap() const;
  /// True once the cloud holds enough scans to tell that a scan is of another place.
  [[nodiscard]] bool is_established() const { return covisibility_.num_scans() >= CovisibilityGrid::kMinScans; }
  /// Empties the cloud and begins it with the filtered scan.
  void restart();
  /// Takes in what the sensor has left `cloud_lag_m` behind. @param travel_m  way of the sensor so far
  void advance(double travel_m);
  /// The same, and hands in the filtered scan for later.
  void add(double travel_m);

  [[nodiscard]] std::size_t num_points() const { return cloud_.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Pending {
    double travel_m = 0;
    std::vector<Eigen::Vector3f> points;
  };

  void absorb(const std::vector<Eigen::Vector3f>& points);

  double lag_m_;
  PointGrid cloud_;
  CovisibilityGrid covisibility_;
  PointGrid scan_filter_;
  std::vector<Eigen::Vector3f> filtered_;
  std::vector<Pending> pending_;  ///< ring, oldest at pending_begin_
  std::size_t pending_begin_ = 0;
  std::size_t pending_count_ = 0;
};

}  // namespace cloister
