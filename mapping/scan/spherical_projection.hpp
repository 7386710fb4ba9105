#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace cloister {

/// The inverse of a spinning sensor's beam table: which beam of which column looks at a point of the sensor frame L.
///
/// Beams leave a ring about L's z axis, at `ring_radius_m` and `ring_height_m`. With (rho, z) the distance from the
/// axis and the height of a point,
///
///     d = |(rho - ring_radius, z - ring_height)|          distance from the ring, what a beam measures
///     sine of the elevation = (z - ring_height) / d       gives the row, by a table of the sensor's own beams
///     column = (azimuth - azimuth0) * columns_per_rad     of the destaggered image: azimuths of all rows line up
///
/// to within the spin that differs inside a column: a row's beams stand `residual` (less than half a column) off.
/// Rows run from the top down.
struct SphericalProjection {
  struct Row {
    float elevation_rad;
    float sin_elevation;
    float cos_elevation;
    float sin_residual;  ///< of the row's azimuth against its column of the destaggered image
    float cos_residual;
    float range_offset_m;  ///< a measured range minus this is the distance from the ring
    float tangential_m;    ///< beams pass the axis at this distance, counter-clockwise positive
    int shift;  ///< column of the scan = (column of the image + shift) mod num_columns; 0..num_columns-1
  };

  int num_columns = 0;  ///< a power of two
  float ring_radius_m = 0;
  float ring_height_m = 0;
  float azimuth0_rad = 0;
  float columns_per_rad = 0;   ///< negative for a sensor that turns clockwise, seen from above
  float max_rows_per_rad = 0;  ///< where rows are closest together
  int max_shift = 0;  ///< largest distance of a row's columns from the image's, either way round
  int squaring = 0;   ///< 2^squaring columns are about as far apart as two rows
  std::vector<Row> rows;
  std::vector<float> cos_azimuth;  ///< [num_columns] of the image
  std::vector<float> sin_azimuth;
  std::vector<float>
      row_of_sine;  ///< [kSineSteps + 2] fractional row by (1 + sine of elevation) / 2 * kSineSteps

  static constexpr int kSineSteps = 4096;

  [[nodiscard]] int num_rows() const { return static_cast<int>(rows.size()); }
};

/// Finds the projection of a beam table.
/// @param direction_L, origin_L  [num_beams x num_columns] as in ScanGeometry
/// @return nothing for a table that is none of a spinning sensor: rows of constant and falling elevation, evenly spaced
/// columns, a power of two of them (64 at the least), to within a tenth of a milliradian and a millimetre
[[nodiscard]] std::optional<SphericalProjection> fit_projection(
    int num_beams, int num_columns, const std::vector<Eigen::Vector3f>& direction_L,
    const std::vector<Eigen::Vector3f>& origin_L);

}  // namespace cloister
