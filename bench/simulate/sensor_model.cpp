#include "bench/simulate/sensor_model.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

constexpr int kLidarPort = 7502;
constexpr int kImuPort = 7503;
constexpr double kRadians = std::numbers::pi / 180.0;

/// Two decimals, as the sensor lists its angles.
double round_to_hundredths(double value) { return std::round(value * 100.0) / 100.0; }

/// Beams spread evenly from top to bottom, each with the small deviation of a real, calibrated
/// unit; four neighbouring beams are offset in azimuth because their emitters sit side by side.
void fill_beams(int count, double top_deg, double bottom_deg, std::uint64_t unit,
                SensorModel* sensor) {
  constexpr std::array<double, 4> kOffset_deg = {3.12, 1.03, -1.05, -3.14};
  RandomStream random = random_stream(unit, Purpose::kBeams);
  for (int beam = 0; beam < count; ++beam) {
    const double altitude =
        top_deg + (bottom_deg - top_deg) * beam / (count - 1) + random.uniform(-0.08, 0.08);
    // A beam that leaves the lens steeply covers more azimuth for the same offset on the emitter
    // board.
    const double offset =
        kOffset_deg[static_cast<std::size_t>(beam % 4)] / std::sqrt(std::cos(altitude * kRadians));
    sensor->beam_altitude_deg.push_back(round_to_hundredths(altitude));
    sensor->beam_azimuth_deg.push_back(round_to_hundredths(offset + random.uniform(-0.06, 0.06)));
  }
}

}  // namespace

std::vector<int> SensorModel::pixel_shift() const {
  std::vector<int> shift;
  for (const double azimuth_deg : beam_azimuth_deg) {
    shift.push_back(static_cast<int>(std::lround(azimuth_deg / 360.0 * columns)));
  }
  return shift;
}

Result<SensorModel> make_sensor(const std::string& name) {
  SensorModel sensor;
  sensor.name = name;
  if (name == "os0-64") {
    sensor.prod_line = "OS-0-64";
    sensor.beam_origin_mm = 27.67;
    sensor.max_range_m = 50.0;
    sensor.dark_range_m = 22.0;
    fill_beams(64, 45.3, -45.6, 64'000, &sensor);
    return sensor;
  }
  if (name == "os1-64") {
    sensor.prod_line = "OS-1-64";
    sensor.beam_origin_mm = 15.806;
    sensor.max_range_m = 120.0;
    sensor.dark_range_m = 60.0;
    fill_beams(64, 16.5, -16.7, 64'001, &sensor);
    return sensor;
  }
  return fail(ErrorKind::kUsage, "--sensor " + name + ": not known: choose os0-64 or os1-64");
}

BeamFan make_beam_fan(const SensorModel& sensor) {
  BeamFan fan;
  const double beam_origin_m = sensor.beam_origin_mm * 1e-3;
  // lidar_to_sensor_transform: half a turn about z, then up.
  const auto to_sensor = [&](double x, double y, double z) {
    return Eigen::Vector3d(-x, -y, z + sensor.lidar_height_mm * 1e-3);
  };
  for (int column = 0; column < sensor.columns; ++column) {
    const double encoder =
        2.0 * std::numbers::pi * (1.0 - static_cast<double>(column) / sensor.columns);
    fan.origins_L.push_back(
        to_sensor(beam_origin_m * std::cos(encoder), beam_origin_m * std::sin(encoder), 0.0)
            .cast<float>());
    for (int beam = 0; beam < sensor.beams(); ++beam) {
      const double azimuth = encoder - sensor.beam_azimuth_deg[beam] * kRadians;
      const double altitude = sensor.beam_altitude_deg[beam] * kRadians;
      fan.directions_L.push_back(Eigen::Vector3d(-std::cos(azimuth) * std::cos(altitude),
                                                 -std::sin(azimuth) * std::cos(altitude),
                                                 std::sin(altitude))
                                     .cast<float>());
    }
  }
  return fan;
}

std::string format_metadata(const SensorModel& sensor) {
  const int columns = sensor.columns;
  nlohmann::ordered_json metadata;
  metadata["beam_altitude_angles"] = sensor.beam_altitude_deg;
  metadata["beam_azimuth_angles"] = sensor.beam_azimuth_deg;
  metadata["build_rev"] = "v2.1.2";
  metadata["data_format"] = {{"column_window", {0, columns - 1}},
                             {"columns_per_frame", columns},
                             {"columns_per_packet", 16},
                             {"pixel_shift_by_row", sensor.pixel_shift()},
                             {"pixels_per_column", sensor.beams()},
                             {"udp_profile_lidar", "LEGACY"}};
  metadata["image_rev"] = "simulated";
  metadata["imu_to_sensor_transform"] = {1, 0, 0, 6.253, 0, 1, 0, -11.775,
                                         0, 0, 1, 7.645, 0, 0, 0, 1};
  metadata["json_calibration_version"] = 4;
  metadata["lidar_mode"] = std::to_string(columns) + "x" + std::to_string(sensor.rate_hz);
  metadata["lidar_origin_to_beam_origin_mm"] = sensor.beam_origin_mm;
  metadata["lidar_to_sensor_transform"] = {
      -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, sensor.lidar_height_mm, 0, 0, 0, 1};
  metadata["prod_line"] = sensor.prod_line;
  metadata["prod_sn"] = "000000000000";
  metadata["status"] = "RUNNING";
  metadata["udp_port_imu"] = kImuPort;
  metadata["udp_port_lidar"] = kLidarPort;
  return metadata.dump(4) + "\n";
}

}  // namespace cloister
