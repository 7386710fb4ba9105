#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "firmware_interface/map/map_contents.hpp"
#include "mapping/submap/evidence_sum.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// Log-odds in natural units: n / 20 rather than n * 0.05, which would print as 0.8500000000000001.
[[nodiscard]] inline double natural_log_odds(LogOdds log_odds) {
  return log_odds / (1.0 / kLogOddsStep);
}

/// Asks a map about points in M. The map must outlive the query and stay as it is.
///
/// Threads: `at` may be called from several at once.
class MapQuery {
 public:
  explicit MapQuery(const MapView& map);

  /// Each submap answers with the voxel that contains the point; what they know is added.
  /// Does not allocate. O(submaps): a box test for each, and a voxel look-up inside its box.
  [[nodiscard]] QueryAnswer at(const Eigen::Vector3d& p_M) const;

 private:
  struct Entry {
    Eigen::AlignedBox3d box_M;  ///< around box_S, a little wider
    Eigen::AlignedBox3d box_S;
    Eigen::Isometry3d T_S_M;
    const Submap* submap;
  };
  MapInfo info_;
  LogOdds lowest_, highest_;
  const VoxelStore* store_;
  std::vector<Entry> entries_;  ///< ascending id; submaps that know nothing are left out
};

}  // namespace cloister
