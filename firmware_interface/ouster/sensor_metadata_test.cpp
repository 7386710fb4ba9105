#include "firmware_interface/ouster/sensor_metadata.hpp"

#include <filesystem>
#include <numbers>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

using namespace cloister;
using nlohmann::json;

namespace {

const std::filesystem::path kCaptures =
    std::filesystem::path(CLOISTER_TEST_DATA) / "ouster_captures";

SensorMetadata load(const std::string& file) {
  Result<SensorMetadata> metadata = load_metadata(kCaptures / file);
  REQUIRE_MESSAGE(metadata.has_value(), metadata.error().message);
  return *metadata;
}

// The smallest metadata: sixteen beams.
json reduced() {
  return {{"lidar_mode", "512x20"},
          {"beam_altitude_angles", std::vector<double>(16, 1.0)},
          {"beam_azimuth_angles", std::vector<double>(16, 0.0)}};
}

std::string message_of(const std::string& text) {
  const Result<SensorMetadata> metadata = parse_metadata(text, "metadata.json");
  REQUIRE_FALSE(metadata.has_value());
  CHECK(metadata.error().kind == ErrorKind::kInput);
  CHECK(metadata.error().message.starts_with("metadata.json"));
  CHECK(metadata.error().message.find('\n') == std::string::npos);
  return metadata.error().message;
}

// The message about reduced metadata with one field set to something.
std::string message_with(const std::string& key, const json& value) {
  json metadata = reduced();
  metadata[key] = value;
  const std::string message = message_of(metadata.dump(2));
  CHECK(message.find(key.substr(key.rfind('/') + 1)) != std::string::npos);
  return message;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr double kDeg = std::numbers::pi / 180.0;

}  // namespace

TEST_CASE("the flat form is read") {
  const SensorMetadata metadata = load("OS-0-128-U1_v2.3.0_1024x10.json");
  CHECK(metadata.product_line == "OS-0-128");
  CHECK(metadata.serial_number == 122150000150);
  CHECK(metadata.init_id == 5431292);
  CHECK(metadata.num_columns == 1024);
  CHECK(metadata.rate_hz == 10);
  CHECK(metadata.num_beams == 128);
  CHECK(metadata.profile == UdpProfile::kRng15Rfl8Nir8);
  CHECK(metadata.pixel_shift[0] == 64);
  CHECK(metadata.pixel_shift[127] == 0);
  CHECK(metadata.lidar_port == 7502);
  CHECK(metadata.imu_port == 7503);
  CHECK(metadata.t_lidar_beam_m.isApprox(Eigen::Vector3d(0.02767, 0.0, 0.0)));
}

TEST_CASE("the flat form of older firmware lacks profile, ports and init id") {
  const SensorMetadata metadata = load("OS-2-32-U0_v2.0.0_1024x10.json");
  CHECK(metadata.serial_number == 992029000352);
  CHECK(metadata.init_id == 0);
  CHECK(metadata.rate_hz == 20);
  CHECK(metadata.num_beams == 32);
  CHECK(metadata.profile == UdpProfile::kLegacy);
  CHECK(metadata.lidar_port == 7502);
  CHECK(metadata.T_sensor_lidar.translation().z() == doctest::Approx(0.074296));
}

TEST_CASE("the reduced form falls back on the documented defaults") {
  const SensorMetadata metadata = load("OS-1-64_sensor_config_reduced.json");
  CHECK(metadata.product_line.empty());
  CHECK(metadata.serial_number == 0);
  CHECK(metadata.num_beams == 64);
  CHECK(metadata.num_columns == 1024);
  CHECK(metadata.columns_per_packet == 16);
  CHECK(metadata.column_window.first == 0);
  CHECK(metadata.column_window.last == 1023);
  CHECK(metadata.profile == UdpProfile::kLegacy);
  CHECK(metadata.lidar_port == 7502);
  CHECK(metadata.imu_port == 7503);
  CHECK(metadata.beam_altitude_rad[0] == doctest::Approx(16.46 * kDeg));
  CHECK(metadata.beam_azimuth_rad[3] == doctest::Approx(-3.3 * kDeg));
  CHECK(metadata.t_lidar_beam_m.isApprox(Eigen::Vector3d(0.012163, 0.0, 0.0)));
  CHECK(metadata.T_sensor_lidar.linear().isApprox(
      Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal().toDenseMatrix()));
  CHECK(metadata.T_sensor_lidar.translation().isApprox(Eigen::Vector3d(0.0, 0.0, 0.03618)));
  CHECK(metadata.pixel_shift[0] == 18);
  CHECK(metadata.pixel_shift[3] == 0);
}

TEST_CASE("the nested form is read") {
  const SensorMetadata metadata = load("windowed_frame2_0.json");
  CHECK(metadata.product_line == "OS-0-128");
  CHECK(metadata.serial_number == 992108000265);
  CHECK(metadata.init_id == 7109747);
  CHECK(metadata.num_columns == 512);
  CHECK(metadata.lidar_port == 53750);
  CHECK(metadata.column_window.first == 370);
  CHECK(metadata.column_window.last == 85);
  CHECK(metadata.column_window.num_columns(512) == 228);
  CHECK(metadata.column_window.contains(0));
  CHECK(metadata.column_window.contains(511));
  CHECK_FALSE(metadata.column_window.contains(86));
  CHECK(load("same_ports.1.json").profile == UdpProfile::kFusaRng15Rfl8Nir8Dual);
}

TEST_CASE("the beam origin's default goes by product line") {
  const auto origin_mm = [](const char* product_line) {
    json metadata = reduced();
    metadata["prod_line"] = product_line;
    return parse_metadata(metadata.dump(), "m").value().t_lidar_beam_m.x() * 1000.0;
  };
  CHECK(origin_mm("OS-0-128") == doctest::Approx(27.67));
  CHECK(origin_mm("OS-1-32-G") == doctest::Approx(15.806));
  CHECK(origin_mm("OS-2-64") == doctest::Approx(13.762));
  CHECK(origin_mm("") == doctest::Approx(12.163));
}

TEST_CASE("a null stands for an absent field, and a serial number that is no number for none") {
  json metadata = reduced();
  metadata["udp_port_lidar"] = nullptr;
  metadata["prod_sn"] = "prototype 7";
  const Result<SensorMetadata> parsed = parse_metadata(metadata.dump(), "m");
  REQUIRE(parsed.has_value());
  CHECK(parsed->lidar_port == 7502);
  CHECK(parsed->serial_number == 0);
}

TEST_CASE("text that is not JSON is refused with its line") {
  CHECK(has(message_of("{\n\"lidar_mode\": \"1024x10\",\n oops}"), "metadata.json:3: is not JSON"));
  CHECK(has(message_of(""), "metadata.json:1"));
  CHECK(has(message_of("[1, 2]"), "not a JSON object"));
  CHECK(has(message_of("{\"beam_altitude_angles\": [1e999]}"), "not JSON"));
  CHECK(has(message_of("{\"beam_altitude_angles\": [NaN]}"), "not JSON"));
  const std::string whole = reduced().dump();
  for (std::size_t length = 0; length < whole.size(); ++length) message_of(whole.substr(0, length));
}

TEST_CASE("a missing field is named") {
  for (const char* key : {"lidar_mode", "beam_altitude_angles", "beam_azimuth_angles"}) {
    json metadata = reduced();
    metadata.erase(key);
    CHECK(has(message_of(metadata.dump()), std::string(key) + " is missing"));
  }
}

TEST_CASE("a field that is wrong is refused with its line, name and value") {
  CHECK(has(message_with("lidar_mode", "1000x10"), "\"1000x10\" is none of 512x10"));
  CHECK(has(message_with("lidar_mode", 7), "is not a string"));
  CHECK(has(message_with("beam_altitude_angles", std::vector<double>(17, 0.0)), "has 17 entries"));
  CHECK(has(message_with("beam_azimuth_angles", std::vector<double>(15, 0.0)), "has 15 entries"));
  CHECK(has(message_with("beam_azimuth_angles", "none"), "is not a list"));
  CHECK(
      has(message_with("beam_azimuth_angles", {0, "x"}), "beam_azimuth_angles[1] is not a number"));
  CHECK(has(message_with("beam_altitude_angles", {0, 91.5}), "beam_altitude_angles[1] = 91.5"));
  CHECK(has(message_with("udp_port_lidar", 65536), "= 65536"));
  CHECK(has(message_with("udp_port_lidar", 75.5), "is not a whole number"));
  CHECK(has(message_with("udp_port_lidar", 18446744073709551615ULL), "is not within"));
  CHECK(has(message_with("lidar_origin_to_beam_origin_mm", "12"), "is not a number"));
  CHECK(has(message_with("lidar_to_sensor_transform", {1, 2, 3}), "has 3 entries instead of 16"));
  CHECK(has(message_with("lidar_to_sensor_transform", std::vector<int>(16, 1)), "rotation"));
  CHECK(has(
      message_with("beam_to_lidar_transform", {1, 0, 0, 16, 0, 1, 0, 9, 0, 0, 1, 0, 0, 0, 0, 1}),
      "more than a shift along x and z"));
  CHECK(message_with("udp_port_lidar", -1).starts_with("metadata.json:"));
}

TEST_CASE("a data format that contradicts the mode or the tables is refused") {
  const auto message_with_format = [](const json& format) {
    json metadata = reduced();
    metadata["data_format"] = format;
    return message_of(metadata.dump());
  };
  CHECK(has(message_with_format({{"columns_per_frame", 1024}}), "contradicts lidar_mode"));
  CHECK(has(message_with_format({{"pixels_per_column", 64}}), "contradicts the 16 beam angles"));
  CHECK(has(message_with_format({{"columns_per_packet", 0}}), "columns_per_packet = 0"));
  CHECK(has(message_with_format({{"columns_per_packet", 24}}), "does not divide"));
  CHECK(has(message_with_format({{"column_window", {0, 512}}}), "column_window[1] = 512"));
  CHECK(has(message_with_format({{"column_window", {0}}}), "has 1 entries instead of 2"));
  CHECK(has(message_with_format({{"pixel_shift_by_row", {1, 2}}}), "has 2 entries for 16 beams"));
  CHECK(has(message_with_format({{"udp_profile_lidar", "RNG99\n"}}), "\"RNG99\\n\" is none of"));
}

TEST_CASE("a metadata file that is not there is refused with its name") {
  const Result<SensorMetadata> metadata = load_metadata("/no/such/metadata.json");
  REQUIRE_FALSE(metadata.has_value());
  CHECK(metadata.error().kind == ErrorKind::kInput);
  CHECK(has(metadata.error().message, "/no/such/metadata.json"));
}
