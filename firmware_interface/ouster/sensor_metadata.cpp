#include "firmware_interface/ouster/sensor_metadata.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "firmware_interface/files/read_file.hpp"

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

int line_at(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  return 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
}

// Reads fields one by one and remembers the first thing that is wrong; after that every read is
// harmless.
class Reader {
 public:
  Reader(const json& root, std::string_view text, std::string_view file_name)
      : root_(root), text_(text), file_name_(file_name) {}

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  void refuse(std::string_view key, const std::string& what, const std::string& index = "") {
    if (error_) return;
    const std::size_t byte = text_.find('"' + std::string(key) + '"');
    const std::string line =
        byte == std::string_view::npos ? "" : ":" + std::to_string(line_at(text_, byte));
    error_ = Error{ErrorKind::kInput, std::string(file_name_) + line + ": " + std::string(key) +
                                          index + " " + what + "; use the sensor's own metadata"};
  }

  // The first of the places where a field may stand, by form: flat, then nested.
  const json* find(std::string_view key, std::initializer_list<const char*> sections) const {
    for (const char* section : sections) {
      const json* object = &root_;
      if (*section != '\0') {
        const auto found = root_.find(section);
        if (found == root_.end()) continue;
        object = &*found;
      }
      if (!object->is_object()) continue;
      const auto found = object->find(key);
      if (found != object->end() && !found->is_null()) return &*found;
    }
    return nullptr;
  }

  std::optional<std::int64_t> integer(std::string_view key,
                                      std::initializer_list<const char*> sections, std::int64_t min,
                                      std::int64_t max) {
    const json* value = find(key, sections);
    if (value == nullptr) return std::nullopt;
    return integer_of(*value, key, "", min, max);
  }

  std::vector<int> integers(std::string_view key, std::initializer_list<const char*> sections,
                            std::int64_t min, std::int64_t max) {
    std::vector<int> values;
    for_each(key, sections, [&](const json& value, const std::string& index) {
      values.push_back(static_cast<int>(integer_of(value, key, index, min, max).value_or(0)));
    });
    return values;
  }

  std::optional<double> number(std::string_view key, std::initializer_list<const char*> sections,
                               double max_magnitude) {
    const json* value = find(key, sections);
    if (value == nullptr) return std::nullopt;
    return number_of(*value, key, "", max_magnitude);
  }

  std::vector<double> numbers(std::string_view key, std::initializer_list<const char*> sections,
                              double max_magnitude) {
    std::vector<double> values;
    for_each(key, sections, [&](const json& value, const std::string& index) {
      values.push_back(number_of(value, key, index, max_magnitude).value_or(0.0));
    });
    return values;
  }

  std::optional<std::string> string(std::string_view key,
                                    std::initializer_list<const char*> sections) {
    const json* value = find(key, sections);
    if (value == nullptr) return std::nullopt;
    if (value->is_string()) return value->get<std::string>();
    refuse(key, "is not a string");
    return std::nullopt;
  }

  /// A 4x4 row-major transform in millimetres, as one in metres.
  std::optional<Pose> transform(std::string_view key, std::initializer_list<const char*> sections) {
    const std::vector<double> values = numbers(key, sections, 1e5);
    if (values.empty()) {
      if (find(key, sections) != nullptr) refuse(key, "is not a list of 16 numbers");
      return std::nullopt;
    }
    if (values.size() != 16) {
      refuse(key, "has " + std::to_string(values.size()) + " entries instead of 16");
      return std::nullopt;
    }
    const Eigen::Matrix4d matrix =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    const bool is_rigid = (rotation.transpose() * rotation).isIdentity(kTransformTolerance) &&
                          rotation.determinant() > 0.0 &&
                          (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() <=
                              kTransformTolerance;
    if (!is_rigid) {
      refuse(key, "is not a rotation and a shift");
      return std::nullopt;
    }
    Pose pose = Pose::Identity();
    pose.linear() = rotation;
    pose.translation() = matrix.topRightCorner<3, 1>() * kMetresPerMm;
    return pose;
  }

 private:
  template <typename Visit>
  void for_each(std::string_view key, std::initializer_list<const char*> sections, Visit visit) {
    const json* list = find(key, sections);
    if (list == nullptr) return;
    if (!list->is_array()) return refuse(key, "is not a list");
    for (std::size_t i = 0; i < list->size(); ++i) visit((*list)[i], "[" + std::to_string(i) + "]");
  }

  std::optional<std::int64_t> integer_of(const json& value, std::string_view key,
                                         const std::string& index, std::int64_t min,
                                         std::int64_t max) {
    // An unsigned number past the signed range would wrap; as a double it is only found too large.
    const double rough = value.is_number() ? value.get<double>() : 0.0;
    if (!value.is_number() || rough != std::floor(rough)) {
      refuse(key, "is not a whole number", index);
      return std::nullopt;
    }
    if (!(rough >= static_cast<double>(min) && rough <= static_cast<double>(max))) {
      refuse(key,
             "= " + value.dump() + " lies outside " + std::to_string(min) + " to " +
                 std::to_string(max),
             index);
      return std::nullopt;
    }
    return static_cast<std::int64_t>(rough);
  }

  std::optional<double> number_of(const json& value, std::string_view key, const std::string& index,
                                  double max_magnitude) {
    if (!value.is_number()) {
      refuse(key, "is not a number", index);
      return std::nullopt;
    }
    const double number = value.get<double>();
    if (!(std::abs(number) <= max_magnitude)) {
      refuse(key,
             "= " + value.dump() + " lies outside +-" +
                 std::to_string(static_cast<int>(max_magnitude)),
             index);
      return std::nullopt;
    }
    return number;
  }

  const json& root_;
  std::string_view text_;
  std::string_view file_name_;
  std::optional<Error> error_;
};

void read_identity(Reader& in, SensorMetadata& out) {
  out.product_line = in.string("prod_line", {"", "sensor_info"}).value_or("");
  // Real serial numbers are decimal; any other text is a sensor that packets cannot name.
  const std::string serial = in.string("prod_sn", {"", "sensor_info"}).value_or("");
  const char* end = serial.data() + serial.size();
  if (std::from_chars(serial.data(), end, out.serial_number).ptr != end) out.serial_number = 0;
  out.init_id = static_cast<std::uint32_t>(
      in.integer("initialization_id", {"", "sensor_info"}, 0, 0xffffff).value_or(0));
}

void read_mode(Reader& in, SensorMetadata& out) {
  const std::optional<std::string> name = in.string("lidar_mode", {"", "config_params"});
  if (!name) return in.refuse("lidar_mode", "is missing");
  for (const LidarMode& mode : kLidarModes) {
    if (mode.name != *name) continue;
    out.num_columns = mode.num_columns;
    out.rate_hz = mode.rate_hz;
  }
  if (out.num_columns == 0) {
    in.refuse("lidar_mode",
              "= \"" + *name + "\" is none of 512x10, 512x20, 1024x10, 1024x20, 2048x10");
  }
}

std::vector<double> read_angles(Reader& in, std::string_view key, double max_deg) {
  std::vector<double> angles = in.numbers(key, {"", "beam_intrinsics"}, max_deg);
  if (angles.empty()) in.refuse(key, "is missing or empty");
  for (double& angle : angles) angle *= kRadPerDeg;
  return angles;
}

void read_beams(Reader& in, SensorMetadata& out) {
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

void read_data_format(Reader& in, SensorMetadata& out) {
  const auto sections = {"data_format", "lidar_data_format"};
  const std::int64_t columns =
      in.integer("columns_per_frame", sections, 1, 65535).value_or(out.num_columns);
  if (columns != out.num_columns) {
    in.refuse("columns_per_frame", "= " + std::to_string(columns) + " contradicts lidar_mode (" +
                                       std::to_string(out.num_columns) + " columns)");
  }
  const std::int64_t beams =
      in.integer("pixels_per_column", sections, 1, 65535).value_or(out.num_beams);
  if (beams != out.num_beams) {
    in.refuse("pixels_per_column", "= " + std::to_string(beams) + " contradicts the " +
                                       std::to_string(out.num_beams) + " beam angles");
  }
  out.columns_per_packet =
      static_cast<int>(in.integer("columns_per_packet",
                                  {"data_format", "lidar_data_format", "config_params"}, 1, 256)
                           .value_or(16));
  if (out.num_columns % out.columns_per_packet != 0) {
    in.refuse("columns_per_packet", "= " + std::to_string(out.columns_per_packet) +
                                        " does not divide the revolution's columns");
  }

  out.column_window = {0, out.num_columns - 1};
  const std::vector<int> window = in.integers("column_window", sections, 0, out.num_columns - 1);
  if (in.find("column_window", sections) != nullptr) {
    if (window.size() == 2) {
      out.column_window = {window[0], window[1]};
    } else {
      in.refuse("column_window", "has " + std::to_string(window.size()) + " entries instead of 2");
    }
  }

  out.pixel_shift = in.integers("pixel_shift_by_row", sections, -out.num_columns, out.num_columns);
  if (in.find("pixel_shift_by_row", sections) == nullptr) {
    out.pixel_shift = shifts_of_azimuths(out.beam_azimuth_rad, out.num_columns);
  } else if (static_cast<int>(out.pixel_shift.size()) != out.num_beams) {
    in.refuse("pixel_shift_by_row", "has " + std::to_string(out.pixel_shift.size()) +
                                        " entries for " + std::to_string(out.num_beams) + " beams");
  }
}

void read_transport(Reader& in, SensorMetadata& out) {
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
    in.refuse("udp_profile_lidar", "= \"" + profile + "\" is none of " + names);
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

void read_extrinsics(Reader& in, SensorMetadata& out) {
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
                                       std::to_string(line_at(text, error.byte)) +
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

  Reader in(root, text, file_name);
  SensorMetadata metadata;
  // Each step relies on the ones before it, so the first that fails is the last.
  using Step = void (*)(Reader&, SensorMetadata&);
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
