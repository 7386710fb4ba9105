#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "mapping/scan/scan.hpp"

namespace cloister {

inline constexpr double kDegree = std::numbers::pi / 180;

/// A spinning sensor as its metadata describe it: beams on a ring that turns clockwise, in columns whose rows look in
/// slightly different directions. The sensor frame is half a turn and a height away from the one the beams turn in.
struct SpinningSensor {
  std::vector<double> altitude_rad;  ///< [rows], from the top down
  std::vector<double> azimuth_rad;   ///< [rows], by how much a beam lags behind its column
  int num_columns = 1024;
  double ring_radius_m = 0;
  double lidar_height_m = 0;
};

/// Rows spread unevenly from top to bottom, staggered by four azimuths.
inline SpinningSensor staggered_sensor(int rows, double top_deg, double bottom_deg,
                                       double stagger_deg, int columns) {
  SpinningSensor sensor;
  sensor.num_columns = columns;
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> uneven(-0.08, 0.08), off(-0.04, 0.04);
  const double pitch_deg = rows > 1 ? (top_deg - bottom_deg) / (rows - 1) : 0;
  for (int row = 0; row < rows; ++row) {
    sensor.altitude_rad.push_back((top_deg - pitch_deg * (row + uneven(rng))) * kDegree);
    sensor.azimuth_rad.push_back((stagger_deg * (1 - row % 4 / 1.5) + off(rng)) * kDegree);
  }
  return sensor;
}

/// Like an OS0-64: rows 1.4 degrees apart over 90.
inline SpinningSensor wide_sensor(int columns = 1024) {
  SpinningSensor sensor = staggered_sensor(64, 45, -45, 11, columns);
  sensor.ring_radius_m = 0.02767;
  sensor.lidar_height_m = 0.03618;
  return sensor;
}

/// Like an OS1-64: rows half a degree apart over 33.
inline SpinningSensor long_range_sensor(int columns = 1024) {
  SpinningSensor sensor = staggered_sensor(64, 16.6, -16.6, 3.1, columns);
  sensor.ring_radius_m = 0.01216;
  sensor.lidar_height_m = 0.03618;
  return sensor;
}

inline ScanGeometry geometry_of(const SpinningSensor& sensor) {
  ScanGeometry geometry;
  geometry.num_beams = static_cast<int>(sensor.altitude_rad.size());
  geometry.num_columns = sensor.num_columns;
  geometry.pixel_shift.assign(sensor.altitude_rad.size(), 0);
  const Eigen::Matrix3d R_L_lidar =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (int beam = 0; beam < geometry.num_beams; ++beam) {
    const double up = sensor.altitude_rad[beam];
    for (int column = 0; column < geometry.num_columns; ++column) {
      const double encoder = -2 * std::numbers::pi * column / geometry.num_columns;
      const double around = encoder - sensor.azimuth_rad[beam];
      const Eigen::Vector3d direction(std::cos(up) * std::cos(around),
                                      std::cos(up) * std::sin(around), std::sin(up));
      // Ranges count from the ring's radius before the beam leaves the ring.
      const Eigen::Vector3d origin =
          sensor.ring_radius_m *
          (Eigen::Vector3d(std::cos(encoder), std::sin(encoder), 0) - direction);
      geometry.direction_L.push_back((R_L_lidar * direction).cast<float>());
      geometry.origin_L.push_back(
          (R_L_lidar * origin + Eigen::Vector3d(0, 0, sensor.lidar_height_m)).cast<float>());
    }
  }
  geometry.projection = fit_projection(geometry.num_beams, geometry.num_columns,
                                       geometry.direction_L, geometry.origin_L);
  return geometry;
}

}  // namespace cloister
