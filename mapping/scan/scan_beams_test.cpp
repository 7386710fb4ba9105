#include "mapping/scan/scan_beams.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace cloister {
namespace {

/// A sensor of `beams` rows between +-elevation and 64 columns around, beams from the origin, no pixel shift.
ScanGeometry ring_geometry(int beams, double elevation_rad) {
  ScanGeometry geometry;
  geometry.num_beams = beams;
  geometry.num_columns = 64;
  geometry.pixel_shift.assign(beams, 0);
  for (int beam = 0; beam < beams; ++beam) {
    const double up = beams == 1 ? 0 : elevation_rad * (1 - 2.0 * beam / (beams - 1));
    for (int column = 0; column < 64; ++column) {
      const double around = -2 * std::numbers::pi * column / 64;
      geometry.direction_L.emplace_back(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
      geometry.origin_L.emplace_back(0, 0, 0);
    }
  }
  return geometry;
}

Scan empty_scan(const ScanGeometry& geometry) {
  Scan scan;
  scan.geometry = &geometry;
  scan.ranges_mm.assign(geometry.direction_L.size(), 0);
  scan.column_valid.assign(geometry.num_columns, 1);
  for (int column = 0; column < geometry.num_columns; ++column) scan.column_stamps.push_back({column * 1'000'000});
  scan.stamp = scan.column_stamps.back();
  scan.poses = {{{0}, Pose::Identity()}};
  return scan;
}

TEST_CASE("each column is placed by the pose at its own stamp") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  Pose moved = Pose::Identity();
  moved.translation().x() = 0.63;
  scan.poses = {{{0}, Pose::Identity()}, {{63'000'000}, moved}};
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  REQUIRE(beams.num_returns() == 64);
  for (int column = 0; column < 64; ++column) {
    CHECK(beams.rays()[column].origin_S.x() == doctest::Approx(0.01 * column));
    CHECK((beams.rays()[column].end_S - beams.rays()[column].origin_S).norm() == doctest::Approx(5.0));
  }
}

TEST_CASE("pixels without a return, lost columns and returns that are too near say nothing") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm[0] = 5000;
  scan.ranges_mm[1] = 300;
  scan.ranges_mm[2] = 5000;
  scan.column_valid[2] = 0;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  CHECK(beams.rays().size() == 1);
}

TEST_CASE("a return beyond the longest range is free up to there and no surface") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm[0] = 80'000;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  REQUIRE(beams.rays().size() == 1);
  CHECK_FALSE(beams.rays()[0].is_return);
  CHECK(beams.rays()[0].free_m == doctest::Approx(60.0));
  CHECK(beams.num_returns() == 0);
}

TEST_CASE("a beam stops proving free space one voxel above the floor that it skims") {
  // Two neighbouring beams 2 and 3 degrees below the horizon, 1 m above a floor.
  const double degree = std::numbers::pi / 180;
  ScanGeometry geometry = ring_geometry(2, 0);
  for (int column = 0; column < 64; ++column) {
    const double around = -2 * std::numbers::pi * column / 64;
    for (int beam = 0; beam < 2; ++beam) {
      const double up = -(2 + beam) * degree;
      geometry.direction_L[beam * 64 + column] = Eigen::Vector3f(
          static_cast<float>(std::cos(up) * std::cos(around)), static_cast<float>(std::cos(up) * std::sin(around)),
          static_cast<float>(std::sin(up)));
    }
  }
  Scan scan = empty_scan(geometry);
  for (int beam = 0; beam < 2; ++beam) {
    for (int column = 0; column < 64; ++column) {
      scan.ranges_mm[beam * 64 + column] = static_cast<std::uint32_t>(std::lround(1000 / std::sin((2 + beam) * degree)));
    }
  }
  ScanBeams beams(128);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  for (const Ray& ray : beams.rays()) {
    const Eigen::Vector3f last_free = ray.origin_S + ray.free_m * (ray.end_S - ray.origin_S).normalized();
    CHECK(last_free.z() + 1.0f == doctest::Approx(0.065).epsilon(0.05));
  }
}

TEST_CASE("a cloud is placed by its own pose and its beams begin at its origin") {
  Scan scan;
  scan.kind = Scan::Kind::kCloud;
  scan.points_L = {{3, 4, 0}, {0.1f, 0, 0}, {std::nanf(""), 0, 0}};
  Pose T_R_L = Pose::Identity();
  T_R_L.translation() = Eigen::Vector3d(1, 2, 3);
  scan.poses = {{{0}, T_R_L}};
  ScanBeams beams(8);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  REQUIRE(beams.rays().size() == 1);
  CHECK((beams.rays()[0].end_S - Eigen::Vector3f(4, 6, 3)).norm() < 1e-5f);
  CHECK((beams.rays()[0].origin_S - Eigen::Vector3f(1, 2, 3)).norm() < 1e-6f);
}

TEST_CASE("points at a cloud's origin are no beams, whatever the least range") {
  Scan scan;
  scan.kind = Scan::Kind::kCloud;
  scan.points_L = {{0, 0, 0}, {3, 4, 0}};
  scan.poses = {{{0}, Pose::Identity()}};
  VoxelConfig config;
  config.min_range_m = 0;
  ScanBeams beams(8);
  CHECK(beams.assign(scan, Pose::Identity(), config) == 0);
  CHECK(beams.rays().size() == 1);
}

TEST_CASE("a beam between two others begins where they are half a voxel apart, or where one of them ends") {
  ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  scan.ranges_mm[17] = 0;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  REQUIRE(beams.rays().size() == 63);
  const double column_rad = 2 * std::numbers::pi / 64;
  CHECK(beams.rays()[8].start_m == 0);
  CHECK(beams.rays()[3].start_m == doctest::Approx(0.5 * 0.065 / (2 * column_rad)));
  CHECK(beams.rays()[4].start_m == doctest::Approx(0.5 * 0.065 / (8 * column_rad)));
  // Column 18 stands between 16 and 20; 17 and 19 would be finer ones. Column 17 itself has no return.
  CHECK(beams.rays()[17].start_m == doctest::Approx(0.5 * 0.065 / (4 * column_rad)));
}

TEST_CASE("a beam whose neighbour proves nothing begins at the sensor") {
  ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  scan.ranges_mm[16] = 0;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 0);
  CHECK(beams.rays()[15].start_m == 0);
  CHECK(beams.rays()[16].start_m == 0);
  CHECK(beams.rays()[13].start_m > 0);
}

TEST_CASE("beams beyond the capacity are declined and counted") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  ScanBeams beams(10);
  CHECK(beams.assign(scan, Pose::Identity(), VoxelConfig{}) == 54);
  CHECK(beams.rays().size() == 10);
}

}  // namespace
}  // namespace cloister
