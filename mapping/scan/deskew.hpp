#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// One measured beam in the submap frame S.
struct Ray {
  Eigen::Vector3f origin_S;
  Eigen::Vector3f end_S;     ///< the return, or the point at max_range on the way to it
  float start_m = 0;         ///< up to here neighbouring beams prove free what this one would
  float free_m = 0;          ///< length from the origin that the beam proves free
  bool is_return = false;    ///< `end_S` is a surface; false beyond max_range
};

/// The beams of one scan after motion correction; capacity fixed at construction.
class RayBundle {
 public:
  explicit RayBundle(std::size_t max_rays) {
    rays_.reserve(max_rays);
    free_m_.reserve(max_rays);
  }

  /// Replaces the content by the beams of `scan`, each placed by the sensor's pose at its own column's stamp.
  ///
  /// Beam model: a beam is a thin ray from the beam's origin to its return. It proves free what lies before it, but
  /// for a stretch in front of the return in which it is closer than one voxel to the surface plane: voxel / sin of
  /// the grazing angle, taken from the neighbouring pixels of the organised scan. So a beam that skims a floor does
  /// not carve it. Without neighbours (a cloud, a lone pixel) the stretch is one voxel. Returns beyond max_range
  /// are free up to max_range; returns nearer than min_range and pixels without a return say nothing.
  /// Near the sensor, columns are much closer together than voxels: there a beam begins only where the two beams
  /// beside it in its row are half a voxel apart, or where the shorter of them ends.
  /// @param T_S_R  pose of the scan's reference frame R (its node, or O) in the submap
  /// @return number of returns that did not fit
  /// Real-time: no allocation; O(pixels).
  std::size_t assign(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);

  [[nodiscard]] const std::vector<Ray>& rays() const { return rays_; }
  [[nodiscard]] std::size_t num_returns() const { return num_returns_; }

 private:
  struct Beam {
    float range_m = 0;
    float start_m = 0;
    float free_m = 0;
  };
  void add(const Eigen::Vector3f& origin_S, const Eigen::Vector3f& direction_S, const Beam& beam,
           const VoxelConfig& config);
  void measure_free(const Scan& scan, const VoxelConfig& config);
  [[nodiscard]] float start_of(const ScanGeometry& geometry, int beam, int column, float voxel_m) const;
  void assign_organised(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);
  void assign_cloud(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);

  std::vector<Ray> rays_;
  std::vector<float> free_m_;  ///< [num_beams x num_columns] of an organised scan; 0 where nothing is proven
  std::size_t num_returns_ = 0;
  std::size_t num_declined_ = 0;
};

/// The sensor's pose at a stamp, interpolated between the scan's samples and held constant outside them.
/// @param hint  index of a sample at or before the stamp to begin the search with; moved to the one found
[[nodiscard]] Pose pose_at(const std::vector<PoseSample>& poses, SensorTime stamp, std::size_t& hint);

}  // namespace cloister
