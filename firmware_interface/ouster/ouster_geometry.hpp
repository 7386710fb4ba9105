#pragma once

#include "firmware_interface/ouster/sensor_metadata.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// Where each pixel of this sensor's scans looks, in the sensor frame.
///
/// As the sensor's manual has it ("Lidar range to XYZ"): the encoder turns clockwise seen from
/// above, so that column c of C stands at `theta_e = 2 pi (1 - c / C)`; beam i looks along `theta_e
/// - azimuth_i`, `altitude_i`. With the beam's origin at distance n from the axis, and a range r
/// counted from the axis' side of it,
///
///     x = (r - n) cos(theta_e - azimuth_i) cos(altitude_i) + n_x cos(theta_e)
///     y = (r - n) sin(theta_e - azimuth_i) cos(altitude_i) + n_x sin(theta_e)
///     z = (r - n) sin(altitude_i)                          + n_z
///
/// where (n_x, 0, n_z) is the shift of `beam_to_lidar_transform` and n its length.
/// `lidar_to_sensor_transform` then takes the point to the sensor frame. Written as `origin + r *
/// direction`, the `-n` belongs to the origin. Computed in double, kept in float: an error below
/// 1e-6 of the range.
[[nodiscard]] ScanGeometry make_geometry(const SensorMetadata& metadata);

}  // namespace cloister
