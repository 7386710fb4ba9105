#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "mapping/scan/scan.hpp"

namespace cloister::ros2 {

/// Finds a spinning sensor's beam table from its clouds alone.
///
/// Problem: a driver's cloud holds points, not the beams they lie on; without beams a scan cannot be integrated as an
/// image. Solution: the points of one row and all columns lie, turned about the sensor's z axis, on one straight line,
/// the row's beam. With (rho, z) a point's distance from the axis and its height,
///
///     z = z_0 + rho tan(elevation)
///     azimuth = azimuth_0 + column * step + t / rho,   step = +-2 pi / columns
///
/// where t, a fraction of a millimetre, is the distance at which the beam passes the axis (the ring of emitters turns,
/// and rows look sideways). Both are straight lines, in rho and in 1 / rho; they are fitted by least squares over as
/// many clouds as it takes. Ranges are rounded along the beam, so that rounding does not disturb the fit.
///
/// All beams of a sensor leave one ring, a few centimetres wide: z_0 = ring height - ring radius * tan(elevation). Once
/// the ring is known, elevations are fitted anew through it.
///
/// A row is known once its lines are known to 0.05 mrad. Clouds that were already deskewed, turned into another
/// frame or thinned do not fit (more than 2 mm or 2 mrad off): they are no images of a spinning sensor.
///
/// Threads: one at a time. Cost: some milliseconds a cloud.
class BeamTableFit {
 public:
  BeamTableFit(int num_rows, int num_columns);

  /// Adds what one cloud tells.
  /// @param points_L  [rows x columns], rows from the top down, azimuths lined up or not; NaN without a return
  void add(std::span<const Eigen::Vector3f> points_L);

  [[nodiscard]] int num_known_rows() const;
  [[nodiscard]] bool is_known(int row) const {
    return rows_[static_cast<std::size_t>(row)].is_known;
  }

  /// The table as it is known so far. Rows that nothing was seen by get the place that their neighbours suggest.
  /// @param first_column  [rows]: the column of the image that was fired first, as ScanGeometry counts from it
  /// @return null while fewer than half of the rows are known, or when they are none of one spinning sensor
  [[nodiscard]] std::unique_ptr<const ScanGeometry> geometry(
      std::span<const int> first_column) const;

 private:
  /// Sums for a straight line through (x, y).
  struct Line {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    double offset = 0, slope = 0;  ///< y = offset + slope * x

    void add(double px, double py);
    /// @return whether the line is known to `tolerance` in both numbers and the points lie within `max_rms` of it
    bool solve(double max_rms, double offset_tolerance, double slope_tolerance);
  };
  struct Row {
    Line height_of_rho;
    Line azimuth_of_inverse_rho;
    double azimuth_reference_rad = 0;  ///< azimuths are summed as differences from it
    bool has_reference = false;
    bool is_known = false;
    // The beam at column 0 of the image.
    double elevation_rad = 0, azimuth_rad = 0, tangential_m = 0;
  };
  struct Ring {
    double radius_m = 0, height_m = 0;
  };

  void find_turn(std::span<const Eigen::Vector3f> points_L);
  [[nodiscard]] Ring find_ring() const;
  [[nodiscard]] std::vector<Row> completed_rows(const Ring& ring) const;

  int num_rows_;
  int num_columns_;
  double step_rad_ = 0;  ///< azimuth from one column to the next; 0 while it is not known
  std::vector<Row> rows_;
};

}  // namespace cloister::ros2
