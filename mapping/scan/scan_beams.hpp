#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/config.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/scan/range_image.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// One measured beam in the submap frame S.
struct Ray {
  Eigen::Vector3f origin_S;
  Eigen::Vector3f end_S;  ///< the return, or the point at max_range on the way to it
  float free_m = 0;       ///< length from the origin that the beam proves free
};

/// One scan in the submap frame after motion correction: its returns, and what its beams prove free. Capacity is fixed
/// at construction.
///
/// Beam model. A beam is a thin line from the sensor to its return. It proves free what lies before it, but for a stretch
/// in front of the return: a beam says nothing about voxels that the surface itself may cut. With the surface taken as the
/// plane through the return and its neighbours in the image, of normal n, those are the voxels whose centre is nearer to
/// the plane than half a voxel times |n|_1; along the beam that is, with N = n / (n . beam),
///
///     stretch = voxel / 2 * (|N|_1 + |N| - 1)
///
/// where the second term, for surfaces that are skimmed, stands for what the plane may be wrong by between two rows:
/// so a beam that skims a floor does not carve it, and one that meets a wall squarely clears it up to the next voxel.
/// N comes from differences of range between a pixel and the nearer one of its two neighbours along each axis of the
/// image, above and below the one beside where that is lost; a difference that no surface seen at half a degree explains is an edge, and says nothing about the slope.
/// All of that, and the returns themselves, are taken `return_depth_m` behind what was measured (see VoxelConfig).
/// Returns beyond max_range are free up to max_range; returns nearer than min_range and pixels without a return say
/// nothing.
///
/// An organised scan whose geometry has a projection becomes a RangeImage; any other becomes rays, one a beam, whose
/// stretch is one voxel: without neighbours nothing is known of the surface.
/// Threads: one owner. Real-time: `assign` does not allocate; O(pixels).
class ScanBeams {
 public:
  explicit ScanBeams(std::size_t max_points);

  /// Replaces the content by the beams of `scan`, each placed by the sensor's pose at its own column's stamp.
  /// @param T_S_R  pose of the scan's reference frame R (its node, or O) in the submap
  /// @return number of returns that did not fit
  std::size_t assign(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);

  [[nodiscard]] std::size_t num_returns() const { return num_returns_; }
  /// Return i, a surface point, `return_depth_m` behind what was measured; in no order to rely on.
  [[nodiscard]] Eigen::Vector3f return_S(std::size_t i) const {
    return {x_S_[i], y_S_[i], z_S_[i]};
  }
  /// The same by coordinate: `num_returns` values each.
  [[nodiscard]] const float* x_S() const { return x_S_.data(); }
  [[nodiscard]] const float* y_S() const { return y_S_.data(); }
  [[nodiscard]] const float* z_S() const { return z_S_.data(); }

  [[nodiscard]] bool is_image() const { return image_.projection != nullptr; }
  [[nodiscard]] const RangeImage& image() const { return image_; }  ///< what is free, if is_image()
  [[nodiscard]] const std::vector<Ray>& rays() const { return rays_; }  ///< what is free, if not

 private:
  void place_columns(const Scan& scan, const Pose& T_S_R);
  void assign_image(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);
  void assign_beams(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);
  void assign_cloud(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config);
  void add_ray(const Eigen::Vector3f& origin_S, const Eigen::Vector3f& direction_S, float range_m,
               const VoxelConfig& config);

  RangeImage image_;
  std::vector<Ray> rays_;
  std::vector<float> x_S_, y_S_, z_S_;
  std::vector<float> range_m_;  ///< [num_rows x stride] destaggered, from the ring; 0 = no return
  std::vector<std::uint32_t> column_bits_;  ///< [num_columns] all set where a column was received
  std::vector<float>
      column_pose_;  ///< [12 x 2 num_columns] R_S_L row by row, then t_S; columns repeat
  std::size_t max_points_;
  std::size_t num_returns_ = 0;
  std::size_t num_declined_ = 0;
};

}  // namespace cloister
