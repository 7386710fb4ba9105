#pragma once

#include "firmware_interface/ouster/sensor_metadata.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// Where each pixel of this sensor's scans looks, in the sensor frame.
///
/// As the sensor's manual has it (lidar range data to XYZ): the encoder turns clockwise seen from
/// above, so that column c of C stands at E = 2 pi (1 - c / C). Beam i looks along the azimuth
/// A = E - azimuth_i and the altitude B = altitude_i. With the beam's origin at distance n from the
/// axis, a return of range r lies at
///
///     x = (r - n) cos(A) cos(B) + n_x cos(E)
///     y = (r - n) sin(A) cos(B) + n_x sin(E)
///     z = (r - n) sin(B)        + n_z
///
/// where (n_x, 0, n_z) is the shift of `beam_to_lidar_transform` and n its length, and
/// `lidar_to_sensor_transform` takes it to the sensor frame. In the form `origin + r * direction`
/// the `-n` is part of the origin. Computed in double, kept in float: an error below 1e-6 of r.
[[nodiscard]] ScanGeometry make_geometry(const SensorMetadata& metadata);

}  // namespace cloister
