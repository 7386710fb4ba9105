#include "firmware_interface/ouster/sensor_metadata.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/ouster/metadata_reader.hpp"

namespace cloister {
namespace {

using nlohmann::json;

constexpr double kMetresPerMm = 1e-3;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kTransformTolerance = 1e-4;

struct LidarMode {
  std::string_view name;
  int num_columns;
  int rate_hz;
};
constexpr std::array<LidarMode, 5> kLidarModes = {{{"512x10", 512, 10},
                                                   {"512x20", 512, 20},
                                                   {"1024x10", 1024, 10},
                                                   {"1024x20", 1024, 20},
                                                   {"2048x10", 2048, 10}}};
constexpr std::array<int, 4> kBeamCounts = {16, 32, 64, 128};

void read_identity(MetadataReader& in, SensorMetadata& out) {
  out.product_line = in.string("prod_line", {"", "sensor_info"}).value_or("");
  // Real serial numbers are decimal; any other text is a sensor that packets cannot name.
  const std::string serial = in.string("prod_sn", {"", "sensor_info"}).value_or("");
  const char* end = serial.data() + serial.size();
  if (std::from_chars(serial.data(), end, out.serial_number).ptr != end) out.serial_number = 0;
  out.init_id = static_cast<std::uint32_t>(
      in.integer("initialization_id", {"", "sensor_info"}, 0, 0xffffff).value_or(0));
}

void read_mode(MetadataReader& in, SensorMetadata& out) {
  const std::optional<std::string> name = in.string("lidar_mode", {"", "config_params"});
  if (!name) return in.refuse("lidar_mode", "is missing");
  for (const LidarMode& mode : kLidarModes) {
    if (mode.name != *name) continue;
    out.num_columns = mode.num_columns;
    out.rate_hz = mode.rate_hz;
  }
  if (out.num_columns == 0) {
    in.refuse("lidar_mode",
              "= " + json(*name).dump() + " is none of 512x10, 512x20, 1024x10, 1024x20, 2048x10");
  }
}

std::vector<double> read_angles(MetadataReader& in, std::string_view key, double max_deg) {
  std::vector<double> angles = in.numbers(key, {"", "beam_intrinsics"}, max_deg);
  if (angles.empty()) in.refuse(key, "is missing or empty");
  for (double& angle : angles) angle *= kRadPerDeg;
  return angles;
}

void read_beams(MetadataReader& in, SensorMetadata& out) {
  out.beam_altitude_rad = read_angles(in, "beam_altitude_angles", 90.0);
  out.beam_azimuth_rad = read_angles(in, "beam_azimuth_angles", 360.0);
  out.num_beams = static_cast<int>(out.beam_altitude_rad.size());
  if (std::find(kBeamCounts.begin(), kBeamCounts.end(), out.num_beams) == kBeamCounts.end()) {
    in.refuse("beam_altitude_angles",
              "has " + std::to_string(out.num_beams) + " entries instead of 16, 32, 64 or 128");
  }
  if (out.beam_azimuth_rad.size() != out.beam_altitude_rad.size()) {
    in.refuse("beam_azimuth_angles", "has " + std::to_string(out.beam_azimuth_rad.size()) +
                                         " entries, beam_altitude_angles has " +
                                         std::to_string(out.num_beams));
  }
}

// A beam whose azimuth lies ahead of the encoder meets the same direction so many columns later.
std::vector<int> shifts_of_azimuths(const std::vector<double>& azimuth_rad, int num_columns) {
  const double smallest = *std::min_element(azimuth_rad.begin(), azimuth_rad.end());
  std::vector<int> shifts;
  for (const double azimuth : azimuth_rad) {
    shifts.push_back(static_cast<int>(
        std::lround((azimuth - smallest) / (2.0 * std::numbers::pi) * num_columns)));
  }
  return shifts;
}

void read_data_format(MetadataReader& in, SensorMetadata& out) {
  const auto sections = {"data_format", "lidar_data_format"};
  const int columns = in.integer("columns_per_frame", sections, 1, 65535).value_or(out.num_columns);
  if (columns != out.num_columns) {
    in.refuse("columns_per_frame", "= " + std::to_string(columns) + " contradicts lidar_mode (" +
                                       std::to_string(out.num_columns) + " columns)");
  }
  const int beams = in.integer("pixels_per_column", sections, 1, 65535).value_or(out.num_beams);
  if (beams != out.num_beams) {
    in.refuse("pixels_per_column", "= " + std::to_string(beams) + " contradicts the " +
                                       std::to_string(out.num_beams) + " beam angles");
  }
  out.columns_per_packet = in.integer("columns_per_packet",
                                      {"data_format", "lidar_data_format", "config_params"}, 1, 256)
                               .value_or(16);
  if (out.num_columns % out.columns_per_packet != 0) {
    in.refuse("columns_per_packet", "= " + std::to_string(out.columns_per_packet) +
                                        " does not divide the revolution's columns");
  }

  out.column_window = {0, out.num_columns - 1};
  const std::vector<int> window = in.integers("column_window", sections, 0, out.num_columns - 1);
  if (in.has("column_window", sections)) {
    if (window.size() == 2) {
      out.column_window = {window[0], window[1]};
    } else {
      in.refuse("column_window", "has " + std::to_string(window.size()) + " entries instead of 2");
    }
  }

  out.pixel_shift = in.integers("pixel_shift_by_row", sections, -out.num_columns, out.num_columns);
  if (!in.has("pixel_shift_by_row", sections)) {
    out.pixel_shift = shifts_of_azimuths(out.beam_azimuth_rad, out.num_columns);
  } else if (static_cast<int>(out.pixel_shift.size()) != out.num_beams) {
    in.refuse("pixel_shift_by_row", "has " + std::to_string(out.pixel_shift.size()) +
                                        " entries for " + std::to_string(out.num_beams) + " beams");
  }
}

void read_transport(MetadataReader& in, SensorMetadata& out) {
  const std::string profile =
      in.string("udp_profile_lidar", {"data_format", "lidar_data_format", "", "config_params"})
          .value_or("LEGACY");
  if (const std::optional<UdpProfile> known = find_udp_profile(profile)) {
    out.profile = *known;
  } else {
    std::string names;
    for (const PacketLayout& layout : kPacketLayouts) {
      names += (names.empty() ? "" : ", ") + std::string(layout.name);
    }
    in.refuse("udp_profile_lidar", "= " + json(profile).dump() + " is none of " + names);
  }
  const auto sections = {"", "config_params"};
  out.lidar_port =
      static_cast<std::uint16_t>(in.integer("udp_port_lidar", sections, 0, 65535).value_or(7502));
  out.imu_port =
      static_cast<std::uint16_t>(in.integer("udp_port_imu", sections, 0, 65535).value_or(7503));
}

double default_beam_origin_mm(std::string_view product_line) {
  if (product_line.starts_with("OS-0")) return 27.67;
  if (product_line.starts_with("OS-1")) return 15.806;
  if (product_line.starts_with("OS-2")) return 13.762;
  return 12.163;
}

void read_extrinsics(MetadataReader& in, SensorMetadata& out) {
  const double origin_mm =
      in.number("lidar_origin_to_beam_origin_mm", {"", "beam_intrinsics"}, 1000.0)
          .value_or(default_beam_origin_mm(out.product_line));
  out.t_lidar_beam_m = {origin_mm * kMetresPerMm, 0.0, 0.0};
  if (const auto T_lidar_beam = in.transform("beam_to_lidar_transform", {"", "beam_intrinsics"})) {
    out.t_lidar_beam_m = T_lidar_beam->translation();
    if (!T_lidar_beam->linear().isIdentity(kTransformTolerance) ||
        std::abs(out.t_lidar_beam_m.y()) > kTransformTolerance) {
      in.refuse("beam_to_lidar_transform", "is more than a shift along x and z");
    }
  }

  Pose half_turn = Pose::Identity();
  half_turn.linear().diagonal() = Eigen::Vector3d(-1.0, -1.0, 1.0);
  half_turn.translation().z() = 36.18 * kMetresPerMm;
  out.T_sensor_lidar =
      in.transform("lidar_to_sensor_transform", {"", "lidar_intrinsics"}).value_or(half_turn);
}

}  // namespace

Result<SensorMetadata> parse_metadata(std::string_view text, std::string_view file_name) {
  json root;
  try {
    root = json::parse(text);
  } catch (const json::parse_error& error) {
    return fail(ErrorKind::kInput, std::string(file_name) + ":" +
                                       std::to_string(line_of_byte(text, error.byte)) +
                                       ": is not JSON at byte " + std::to_string(error.byte) +
                                       "; use the sensor's own metadata");
  } catch (const json::exception& error) {
    return fail(ErrorKind::kInput, std::string(file_name) + ": is not JSON: " + error.what() +
                                       "; use the sensor's own metadata");
  }
  if (!root.is_object()) {
    return fail(ErrorKind::kInput,
                std::string(file_name) + ":1: is not a JSON object; use the sensor's own metadata");
  }

  MetadataReader in(root, text, file_name);
  SensorMetadata metadata;
  // Each step relies on the ones before it, so the first that fails is the last.
  using Step = void (*)(MetadataReader&, SensorMetadata&);
  for (const Step step : {Step{read_identity}, Step{read_mode}, Step{read_beams},
                          Step{read_data_format}, Step{read_transport}, Step{read_extrinsics}}) {
    step(in, metadata);
    if (in.error()) return tl::unexpected<Error>(*in.error());
  }
  return metadata;
}

Result<SensorMetadata> load_metadata(const std::filesystem::path& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected<Error>(text.error());
  return parse_metadata(*text, path.string());
}

}  // namespace cloister
