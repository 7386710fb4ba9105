#include "mapping/scan/spherical_projection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include "mapping/scan/spinning_sensor_for_tests.hpp"

namespace cloister {
namespace {

/// Where a point lies in the destaggered image, by the formula of the header.
struct ImagePlace {
  double row, column, distance_m;
};

ImagePlace project(const SphericalProjection& projection, const Eigen::Vector3d& p_L) {
  const double rho = std::hypot(p_L.x(), p_L.y()) - projection.ring_radius_m;
  const double z = p_L.z() - projection.ring_height_m;
  const double distance_m = std::hypot(rho, z);
  const double step = (1 + z / distance_m) / 2 * SphericalProjection::kSineSteps;
  const int i = static_cast<int>(step);
  const double share = step - i;
  return {(1 - share) * projection.row_of_sine[i] + share * projection.row_of_sine[i + 1],
          (std::atan2(p_L.y(), p_L.x()) - projection.azimuth0_rad) * projection.columns_per_rad,
          distance_m};
}

struct Errors {
  double row = 0, column = 0, distance_m = 0;
};

/// How far off a pixel's points project, at worst.
Errors worst_round_trip(const ScanGeometry& geometry, std::initializer_list<double> ranges_m) {
  const SphericalProjection& projection = *geometry.projection;
  Errors worst;
  for (int beam = 0; beam < geometry.num_beams; ++beam) {
    const SphericalProjection::Row& row = projection.rows[beam];
    for (int column = 0; column < geometry.num_columns; ++column) {
      const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      for (const double range_m : ranges_m) {
        const Eigen::Vector3d p_L = geometry.origin_L[pixel].cast<double>() +
                                    range_m * geometry.direction_L[pixel].cast<double>();
        const ImagePlace place = project(projection, p_L);
        const double column_error = std::remainder(place.column - (column - row.shift),
                                                   static_cast<double>(geometry.num_columns));
        worst.row = std::max(worst.row, std::abs(place.row - beam));
        worst.column = std::max(worst.column, std::abs(column_error));
        worst.distance_m =
            std::max(worst.distance_m, std::abs(place.distance_m - (range_m - row.range_offset_m)));
      }
    }
  }
  return worst;
}

TEST_CASE("the points of every pixel project back to its row and its column of the image") {
  for (const int columns : {512, 1024, 2048}) {
    for (const SpinningSensor& sensor : {wide_sensor(columns), long_range_sensor(columns)}) {
      CAPTURE(columns);
      CAPTURE(sensor.ring_radius_m);
      const ScanGeometry geometry = geometry_of(sensor);
      REQUIRE(geometry.projection);
      CHECK(geometry.projection->num_columns == columns);
      CHECK(geometry.projection->num_rows() == 64);
      const Errors far = worst_round_trip(geometry, {8, 20, 60});
      CHECK(far.row < 0.05);
      CHECK(far.column < 0.5 + 0.0055 / 8 * columns / (2 * std::numbers::pi));
      CHECK(far.distance_m < 0.002);
    }
  }
}

TEST_CASE("a row's residual and its distance from the axis tell where in its column a beam looks") {
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    REQUIRE(geometry.projection);
    const SphericalProjection& projection = *geometry.projection;
    for (int beam = 0; beam < geometry.num_beams; ++beam) {
      const SphericalProjection::Row& row = projection.rows[beam];
      const double residual = std::atan2(row.sin_residual, row.cos_residual);
      CHECK(std::abs(residual * projection.columns_per_rad) <= 0.5);
      for (const double range_m : {0.6, 2.0, 30.0}) {
        const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + 300;
        const Eigen::Vector3d p_L = geometry.origin_L[pixel].cast<double>() +
                                    range_m * geometry.direction_L[pixel].cast<double>();
        const double aside = std::asin(row.tangential_m / std::hypot(p_L.x(), p_L.y()));
        const double expected = 300 - row.shift + (residual + aside) * projection.columns_per_rad;
        const double column = project(projection, p_L).column;
        CHECK(std::abs(std::remainder(column - expected, 1024.0)) < 0.01);
      }
    }
  }
}

TEST_CASE("a projection knows the ring its beams leave, and how its rows are spaced") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  REQUIRE(geometry.projection);
  const SphericalProjection& projection = *geometry.projection;
  CHECK(projection.ring_height_m == doctest::Approx(0.03618).epsilon(0.02));
  CHECK(projection.columns_per_rad == doctest::Approx(-1024 / (2 * std::numbers::pi)));
  CHECK(projection.squaring == 2);  // rows 1.4 degrees apart, columns 0.35
  int max_shift = 0;
  for (int row = 0; row < 64; ++row) {
    CHECK(projection.rows[row].elevation_rad ==
          doctest::Approx(wide_sensor().altitude_rad[row]).epsilon(1e-4));
    CHECK(projection.rows[row].shift >= 0);
    CHECK(projection.rows[row].shift < 1024);
    max_shift = std::max(max_shift,
                         std::min(projection.rows[row].shift, 1024 - projection.rows[row].shift));
    if (row > 0) {
      const float pitch =
          projection.rows[row - 1].elevation_rad - projection.rows[row].elevation_rad;
      CHECK(pitch * projection.max_rows_per_rad >= 0.9999f);
    }
  }
  CHECK(projection.max_shift == max_shift);
}

TEST_CASE("a sensor that turns counter-clockwise has a projection as well") {
  ScanGeometry geometry = geometry_of(long_range_sensor());
  for (auto* vectors : {&geometry.direction_L, &geometry.origin_L}) {
    for (Eigen::Vector3f& v : *vectors) v.y() = -v.y();
  }
  geometry.projection = fit_projection(geometry.num_beams, geometry.num_columns,
                                       geometry.direction_L, geometry.origin_L);
  REQUIRE(geometry.projection);
  CHECK(geometry.projection->columns_per_rad > 0);
  const Errors worst = worst_round_trip(geometry, {8, 60});
  CHECK(worst.row < 0.05);
  CHECK(worst.column < 0.6);
}

TEST_CASE("beam tables that no spinning sensor has are refused") {
  const ScanGeometry good = geometry_of(long_range_sensor());
  const auto fits = [](const ScanGeometry& g) {
    return fit_projection(g.num_beams, g.num_columns, g.direction_L, g.origin_L).has_value();
  };
  REQUIRE(fits(good));

  ScanGeometry bent = good;  // one pixel half a milliradian off
  bent.direction_L[12'345] =
      Eigen::AngleAxisf(5e-4f, Eigen::Vector3f::UnitZ()) * bent.direction_L[12'345];
  CHECK_FALSE(fits(bent));
  ScanGeometry tilted = good;  // elevations that change along a row
  for (Eigen::Vector3f& direction : tilted.direction_L) {
    direction = Eigen::AngleAxisf(0.01f, Eigen::Vector3f::UnitX()) * direction;
  }
  CHECK_FALSE(fits(tilted));
  ScanGeometry moved = good;  // an origin 5 mm off
  moved.origin_L[12'345].z() += 0.005f;
  CHECK_FALSE(fits(moved));
  ScanGeometry upside_down = good;
  for (Eigen::Vector3f& direction : upside_down.direction_L) direction.z() = -direction.z();
  CHECK_FALSE(fits(upside_down));
  ScanGeometry camera = good;  // half a turn only
  for (int beam = 0; beam < camera.num_beams; ++beam) {
    for (int column = 0; column < camera.num_columns; ++column) {
      const double around = std::numbers::pi * column / camera.num_columns, up = 0.2 - 0.005 * beam;
      camera.direction_L[beam * camera.num_columns + column] =
          Eigen::Vector3d(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                          std::sin(up))
              .cast<float>();
    }
  }
  CHECK_FALSE(fits(camera));
  ScanGeometry shorter = good;
  shorter.direction_L.pop_back();
  CHECK_FALSE(fits(shorter));
}

TEST_CASE("only powers of two of at least 64 columns are projected") {
  for (const int columns : {32, 360, 1000, 1023})
    CHECK_FALSE(geometry_of(wide_sensor(columns)).projection);
  for (const int columns : {64, 512, 4096}) CHECK(geometry_of(wide_sensor(columns)).projection);
  CHECK_FALSE(fit_projection(0, 1024, {}, {}));
}

TEST_CASE("a sensor of a single row has a projection") {
  SpinningSensor sensor = staggered_sensor(1, 0, 0, 0, 512);
  const ScanGeometry geometry = geometry_of(sensor);
  REQUIRE(geometry.projection);
  CHECK(worst_round_trip(geometry, {1, 20}).column < 0.5);
}

}  // namespace
}  // namespace cloister
