#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// A spinning lidar as its own metadata describes it, plus what its data sheet says about reach and
/// noise.
struct SensorModel {
  std::string name;       ///< as on the command line
  std::string prod_line;  ///< as in the metadata
  int columns = 1024;     ///< per revolution
  int rate_hz = 10;
  std::vector<double> beam_altitude_deg;  ///< from the top down
  std::vector<double> beam_azimuth_deg;   ///< offset of each beam within its column
  double beam_origin_mm = 0.0;            ///< from the spin axis to where beams leave
  double lidar_height_mm = 36.18;         ///< of the optical centre above the sensor frame's origin
  double max_range_m = 0.0;
  double min_range_m = 0.3;
  double dark_range_m =
      0.0;                 ///< where a target of albedo 0.1, met squarely, is seen half of the time
  double noise_m = 0.01;   ///< standard deviation of a range
  double dropout = 0.002;  ///< share of pixels lost for no reason

  [[nodiscard]] int beams() const { return static_cast<int>(beam_altitude_deg.size()); }
  /// Columns to shift a row by so that azimuths line up, as the metadata lists them.
  [[nodiscard]] std::vector<int> pixel_shift() const;
};

/// @param name os0-64 or os1-64. Errors: kUsage for other names
[[nodiscard]] Result<SensorModel> make_sensor(const std::string& name);

/// Where every pixel looks, in the sensor frame L: x ahead, y left, z up; the lidar frame inside is
/// turned by half a turn and lifted (sensor manual, "lidar coordinate frame" and "sensor coordinate
/// frame").
struct BeamFan {
  std::vector<Eigen::Vector3f>
      directions_L;  ///< [columns x beams], column-major in time: a column's beams together
  std::vector<Eigen::Vector3f> origins_L;  ///< [columns]: where the beams of a column start
};

[[nodiscard]] BeamFan make_beam_fan(const SensorModel& sensor);

/// The sensor's metadata.json in the flat form of the LEGACY firmware.
[[nodiscard]] std::string format_metadata(const SensorModel& sensor);

}  // namespace cloister
