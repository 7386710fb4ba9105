#include "firmware_interface/ouster/ouster_geometry.hpp"

#include <cmath>
#include <numbers>

namespace cloister {

ScanGeometry make_geometry(const SensorMetadata& metadata) {
  ScanGeometry geometry;
  geometry.num_beams = metadata.num_beams;
  geometry.num_columns = metadata.num_columns;
  geometry.pixel_shift = metadata.pixel_shift;
  const std::size_t num_pixels =
      static_cast<std::size_t>(metadata.num_beams) * static_cast<std::size_t>(metadata.num_columns);
  geometry.direction_L.reserve(num_pixels);
  geometry.origin_L.reserve(num_pixels);

  const Eigen::Vector3d& t_beam = metadata.t_lidar_beam_m;
  const double beam_distance_m = t_beam.norm();
  for (int beam = 0; beam < metadata.num_beams; ++beam) {
    const double altitude = metadata.beam_altitude_rad[beam];
    for (int column = 0; column < metadata.num_columns; ++column) {
      const double encoder =
          2.0 * std::numbers::pi * (1.0 - static_cast<double>(column) / metadata.num_columns);
      const double azimuth = encoder - metadata.beam_azimuth_rad[beam];
      const Eigen::Vector3d direction(std::cos(azimuth) * std::cos(altitude),
                                      std::sin(azimuth) * std::cos(altitude), std::sin(altitude));
      const Eigen::Vector3d beam_origin(t_beam.x() * std::cos(encoder),
                                        t_beam.x() * std::sin(encoder), t_beam.z());
      geometry.direction_L.emplace_back(
          (metadata.T_sensor_lidar.linear() * direction).cast<float>());
      geometry.origin_L.emplace_back(
          (metadata.T_sensor_lidar * (beam_origin - beam_distance_m * direction)).cast<float>());
    }
  }
  geometry.projection =
      fit_projection(geometry.num_beams, geometry.num_columns, geometry.direction_L, geometry.origin_L);
  return geometry;
}

}  // namespace cloister
