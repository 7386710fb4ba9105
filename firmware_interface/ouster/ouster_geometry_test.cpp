#include "firmware_interface/ouster/ouster_geometry.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

using namespace cloister;

namespace {

SensorMetadata metadata_of(const std::string& file) {
  Result<SensorMetadata> metadata =
      load_metadata(std::filesystem::path(CLOISTER_TEST_DATA) / "ouster_captures" / file);
  REQUIRE_MESSAGE(metadata.has_value(), metadata.error().message);
  return *metadata;
}

Eigen::Vector3d point_of(const ScanGeometry& geometry, int beam, int column, double range_m) {
  const std::size_t pixel = static_cast<std::size_t>(beam * geometry.num_columns + column);
  return geometry.origin_L[pixel].cast<double>() +
         range_m * geometry.direction_L[pixel].cast<double>();
}

// The manual's formula, one line after the other,
// for a sensor whose frame is half a turn from the lidar's.
Eigen::Vector3d by_the_manual(double azimuth_deg, double altitude_deg, int column, int num_columns,
                              double range_m, double origin_m, double height_m) {
  const double pi = std::numbers::pi;
  const double theta_encoder = 2.0 * pi * (1.0 - static_cast<double>(column) / num_columns);
  const double theta_azimuth = -2.0 * pi * azimuth_deg / 360.0;
  const double phi = 2.0 * pi * altitude_deg / 360.0;
  const double x = (range_m - origin_m) * std::cos(theta_encoder + theta_azimuth) * std::cos(phi) +
                   origin_m * std::cos(theta_encoder);
  const double y = (range_m - origin_m) * std::sin(theta_encoder + theta_azimuth) * std::cos(phi) +
                   origin_m * std::sin(theta_encoder);
  const double z = (range_m - origin_m) * std::sin(phi);
  return {-x, -y, z + height_m};
}

}  // namespace

TEST_CASE("pixels lie where the manual's formula puts them") {
  struct Pixel {
    int beam;
    int column;
    double azimuth_deg;
    double altitude_deg;
  };
  SUBCASE("reduced metadata of an OS1-64") {
    const ScanGeometry geometry = make_geometry(metadata_of("OS-1-64_sensor_config_reduced.json"));
    for (const Pixel& pixel : {Pixel{0, 0, 3.12, 16.46}, Pixel{1, 300, 0.97, 15.88},
                               Pixel{3, 1023, -3.3, 14.8}, Pixel{63, 512, -3.17, -16.75}}) {
      for (const double range_m : {0.5, 12.0, 100.0}) {
        const Eigen::Vector3d expected = by_the_manual(
            pixel.azimuth_deg, pixel.altitude_deg, pixel.column, 1024, range_m, 0.012163, 0.03618);
        CHECK((point_of(geometry, pixel.beam, pixel.column, range_m) - expected).norm() <
              1e-6 * (1.0 + range_m));
      }
    }
  }
  SUBCASE("nested metadata of an OS0-128") {
    const SensorMetadata metadata = metadata_of("crc_test.json");
    const ScanGeometry geometry = make_geometry(metadata);
    for (const int beam : {0, 17, 127}) {
      for (const int column : {0, 1, 200, 511}) {
        const double deg = 180.0 / std::numbers::pi;
        const Eigen::Vector3d expected = by_the_manual(metadata.beam_azimuth_rad[beam] * deg,
                                                       metadata.beam_altitude_rad[beam] * deg,
                                                       column, 512, 20.0, 0.027116, 0.038195);
        CHECK((point_of(geometry, beam, column, 20.0) - expected).norm() < 2e-5);
      }
    }
  }
}

TEST_CASE("a sensor turns clockwise seen from above, beginning at -x of its own frame") {
  SensorMetadata metadata = metadata_of("OS-1-64_sensor_config_reduced.json");
  metadata.beam_azimuth_rad.assign(64, 0.0);
  metadata.beam_altitude_rad.assign(64, 0.0);
  metadata.beam_altitude_rad[0] = 0.5;
  const ScanGeometry geometry = make_geometry(metadata);
  const auto is_near = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).norm() < 1e-5;
  };
  CHECK(is_near(point_of(geometry, 1, 0, 10.0), {-10.0, 0.0, 0.03618}));
  CHECK(is_near(point_of(geometry, 1, 256, 10.0), {0.0, 10.0, 0.03618}));
  CHECK(is_near(point_of(geometry, 1, 512, 10.0), {10.0, 0.0, 0.03618}));
  CHECK(is_near(point_of(geometry, 1, 768, 10.0), {0.0, -10.0, 0.03618}));
  CHECK(point_of(geometry, 0, 0, 10.0).z() > 4.0);
}

TEST_CASE("a beam's azimuth turns it further clockwise") {
  SensorMetadata metadata = metadata_of("OS-1-64_sensor_config_reduced.json");
  const ScanGeometry geometry = make_geometry(metadata);
  const Eigen::Vector3f& ahead = geometry.direction_L[0 * 1024 + 512];   // azimuth 3.12
  const Eigen::Vector3f& behind = geometry.direction_L[3 * 1024 + 512];  // azimuth -3.3
  CHECK(ahead.y() < 0.0F);
  CHECK(behind.y() > 0.0F);
}

TEST_CASE(
    "directions have unit length, and origins the beam's distance from the axis at most twice") {
  for (const std::string file :
       {"OS-1-64_sensor_config_reduced.json", "crc_test.json", "OS-2-128-U1_v2.3.0_1024x10.json"}) {
    const SensorMetadata metadata = metadata_of(file);
    const ScanGeometry geometry = make_geometry(metadata);
    REQUIRE(geometry.direction_L.size() ==
            static_cast<std::size_t>(metadata.num_beams * metadata.num_columns));
    REQUIRE(geometry.origin_L.size() == geometry.direction_L.size());
    REQUIRE(geometry.pixel_shift.size() == static_cast<std::size_t>(metadata.num_beams));
    const Eigen::Vector3f axis = metadata.T_sensor_lidar.translation().cast<float>();
    float worst_length = 0.0F;
    float worst_origin = 0.0F;
    for (std::size_t i = 0; i < geometry.direction_L.size(); ++i) {
      worst_length = std::max(worst_length, std::abs(geometry.direction_L[i].norm() - 1.0F));
      worst_origin = std::max(worst_origin, (geometry.origin_L[i] - axis).norm());
    }
    CHECK(worst_length < 1e-6F);
    CHECK(worst_origin <= 2.0 * metadata.t_lidar_beam_m.norm());
  }
}

TEST_CASE("a beam origin above the axis lifts every point of level beams") {
  SensorMetadata metadata = metadata_of("crc_test.json");
  metadata.beam_altitude_rad.assign(128, 0.0);
  metadata.t_lidar_beam_m = {0.03, 0.0, 0.04};
  const ScanGeometry geometry = make_geometry(metadata);
  // At column 0 and azimuth 0 the point lies at r - |(0.03, 0.04)| + 0.03 along the beam.
  metadata.beam_azimuth_rad.assign(128, 0.0);
  const Eigen::Vector3d point = point_of(make_geometry(metadata), 5, 0, 10.0);
  CHECK(point.x() == doctest::Approx(-(10.0 - 0.05 + 0.03)));
  CHECK(point.z() == doctest::Approx(0.04 + 0.038195));
  CHECK(geometry.origin_L[0].z() == doctest::Approx(0.04 + 0.038195));
}

TEST_CASE("shifting rows by the stated pixel shift lines their azimuths up") {
  for (const std::string file :
       {"OS-1-64_sensor_config_reduced.json", "OS-1-128_v2.3.0_1024x10.json", "crc_test.json",
        "OS-0-32-U1_v2.2.0_1024x10.json"}) {
    CAPTURE(file);
    const SensorMetadata metadata = metadata_of(file);
    const double column_rad = 2.0 * std::numbers::pi / metadata.num_columns;
    // Row i's column c lands in column c + shift: azimuth less shift is the same for all rows.
    double smallest = 1e9;
    double largest = -1e9;
    for (int beam = 0; beam < metadata.num_beams; ++beam) {
      const double rest = metadata.beam_azimuth_rad[beam] / column_rad - metadata.pixel_shift[beam];
      smallest = std::min(smallest, rest);
      largest = std::max(largest, rest);
    }
    CHECK(largest - smallest < 1.5);
  }
}
