#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "firmware_interface/ouster/packet_layout.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// The part of a revolution that the sensor reports: columns `first` to `last`, both included.
/// Where `last < first` the window runs over column 0.
struct ColumnWindow {
  int first = 0;
  int last = 0;

  [[nodiscard]] constexpr bool contains(int column) const {
    return first <= last ? first <= column && column <= last : column >= first || column <= last;
  }
  [[nodiscard]] constexpr int num_columns(int columns_per_frame) const {
    return first <= last ? last - first + 1 : columns_per_frame - first + last + 1;
  }
};

/// What the sensor says about itself and its packets.
/// SI units; angles as the sensor counts them (see make_geometry).
struct SensorMetadata {
  std::string product_line;               ///< "OS-1-64"; empty when not stated
  std::uint64_t serial_number = 0;        ///< 0 when not stated
  std::uint32_t init_id = 0;              ///< 0 when not stated
  int num_columns = 0;                    ///< per revolution: 512, 1024 or 2048
  int rate_hz = 0;                        ///< revolutions per second: 10 or 20
  int num_beams = 0;                      ///< 16, 32, 64 or 128, the length of the beam tables
  std::vector<double> beam_altitude_rad;  ///< [num_beams], from the top down, up positive
  std::vector<double> beam_azimuth_rad;   ///< [num_beams], offset from the encoder's angle
  std::vector<int> pixel_shift;           ///< [num_beams], columns a row moves to align azimuths
  int columns_per_packet = 16;
  ColumnWindow column_window;
  UdpProfile profile = UdpProfile::kLegacy;
  std::uint16_t lidar_port = 7502;  ///< 0: the sensor sends no lidar packets
  std::uint16_t imu_port = 7503;
  /// Where the beams leave, from the lidar's axis, in the frame that turns with the encoder; y = 0.
  Eigen::Vector3d t_lidar_beam_m = Eigen::Vector3d::Zero();
  Pose T_sensor_lidar = Pose::Identity();
};

/// Reads a sensor's metadata: the flat form, the reduced one (only beam tables and mode), or the
/// nested one.
///
/// What a file may leave out (a null stands for that too), and what is taken instead:
///
/// | field                            | taken instead                                             |
/// |----------------------------------|-----------------------------------------------------------|
/// | `columns_per_packet`             | 16                                                        |
/// | `column_window`                  | the whole revolution                                      |
/// | `udp_profile_lidar`              | LEGACY                                                    |
/// | `udp_port_lidar`, `udp_port_imu` | 7502, 7503                                                |
/// | `pixel_shift_by_row`             | the azimuths in columns, rounded, the smallest made 0     |
/// | `lidar_origin_to_beam_origin_mm` | by `prod_line`: OS-0 27.67, OS-1 15.806, OS-2 13.762;     |
/// |                                  | else 12.163, the first generation's OS1                   |
/// | `beam_to_lidar_transform`        | a shift by `lidar_origin_to_beam_origin_mm` along x       |
/// | `lidar_to_sensor_transform`      | half a turn about z, and 36.18 mm up                      |
/// | `prod_line`                      | empty                                                     |
/// | `prod_sn`, `initialization_id`   | 0; the sensor is told from others by its address alone    |
///
/// @param json       the file's text
/// @param file_name  for messages
/// @return the metadata, or kInput with file, line and field of the first thing that is wrong
[[nodiscard]] Result<SensorMetadata> parse_metadata(std::string_view json,
                                                    std::string_view file_name);

/// The same from a file. Also fails with kInput when it cannot be read.
[[nodiscard]] Result<SensorMetadata> load_metadata(const std::filesystem::path& path);

}  // namespace cloister
