#include "mapping/scan/scan_beams.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/scan/spinning_sensor_for_tests.hpp"

namespace cloister {
namespace {

/// A sensor of `beams` rows between +-elevation and 64 columns around, beams from the origin, no pixel shift; without a
/// projection its beams are taken one by one.
ScanGeometry ring_geometry(int beams, double elevation_rad) {
  ScanGeometry geometry;
  geometry.num_beams = beams;
  geometry.num_columns = 64;
  geometry.pixel_shift.assign(beams, 0);
  for (int beam = 0; beam < beams; ++beam) {
    const double up = beams == 1 ? 0 : elevation_rad * (1 - 2.0 * beam / (beams - 1));
    for (int column = 0; column < 64; ++column) {
      const double around = -2 * std::numbers::pi * column / 64;
      geometry.direction_L.emplace_back(std::cos(up) * std::cos(around),
                                        std::cos(up) * std::sin(around), std::sin(up));
      geometry.origin_L.emplace_back(0, 0, 0);
    }
  }
  return geometry;
}

/// Surfaces are where their returns are.
VoxelConfig at_returns() {
  VoxelConfig config;
  config.return_depth_m = 0;
  return config;
}

Scan empty_scan(const ScanGeometry& geometry) {
  Scan scan;
  scan.geometry = &geometry;
  scan.ranges_mm.assign(geometry.direction_L.size(), 0);
  scan.column_valid.assign(geometry.num_columns, 1);
  for (int column = 0; column < geometry.num_columns; ++column)
    scan.column_stamps.push_back({column * 1'000'000});
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
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  REQUIRE(beams.num_returns() == 64);
  for (int column = 0; column < 64; ++column) {
    CHECK(beams.rays()[column].origin_S.x() == doctest::Approx(0.01 * column));
    CHECK((beams.rays()[column].end_S - beams.rays()[column].origin_S).norm() ==
          doctest::Approx(5.0));
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
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  CHECK_FALSE(beams.is_image());
  CHECK(beams.rays().size() == 1);
}

TEST_CASE("a return beyond the longest range is free up to there and no surface") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm[0] = 80'000;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  REQUIRE(beams.rays().size() == 1);
  CHECK(beams.rays()[0].free_m == doctest::Approx(60.0));
  CHECK(beams.num_returns() == 0);
}

TEST_CASE("a beam that knows no neighbours proves nothing in the last voxel before its return") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm[3] = 5000;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  REQUIRE(beams.rays().size() == 1);
  CHECK(beams.rays()[0].free_m == doctest::Approx(5.0 - 0.065));
}

TEST_CASE("a cloud is placed by its own pose and its beams begin at its origin") {
  Scan scan;
  scan.kind = Scan::Kind::kCloud;
  scan.points_L = {{3, 4, 0}, {0.1f, 0, 0}, {std::nanf(""), 0, 0}};
  Pose T_R_L = Pose::Identity();
  T_R_L.translation() = Eigen::Vector3d(1, 2, 3);
  scan.poses = {{{0}, T_R_L}};
  ScanBeams beams(8);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  REQUIRE(beams.rays().size() == 1);
  CHECK((beams.rays()[0].end_S - Eigen::Vector3f(4, 6, 3)).norm() < 1e-5f);
  CHECK((beams.rays()[0].origin_S - Eigen::Vector3f(1, 2, 3)).norm() < 1e-6f);
}

TEST_CASE("points at a cloud's origin are no beams, whatever the least range") {
  Scan scan;
  scan.kind = Scan::Kind::kCloud;
  scan.points_L = {{0, 0, 0}, {3, 4, 0}};
  scan.poses = {{{0}, Pose::Identity()}};
  VoxelConfig config = at_returns();
  config.min_range_m = 0;
  ScanBeams beams(8);
  CHECK(beams.assign(scan, Pose::Identity(), config) == 0);
  CHECK(beams.rays().size() == 1);
}

TEST_CASE("beams beyond the capacity are declined and counted") {
  const ScanGeometry geometry = ring_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  ScanBeams beams(10);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 54);
  CHECK(beams.rays().size() == 10);
}

// ---- Range images ----

/// The ring with its projection.
ScanGeometry ring_image_geometry(int beams, double elevation_rad) {
  ScanGeometry geometry = ring_geometry(beams, elevation_rad);
  geometry.projection = fit_projection(beams, 64, geometry.direction_L, geometry.origin_L);
  REQUIRE(geometry.projection);
  return geometry;
}

/// Ranges of a plane at n . p = offset around the sensor, where beams meet it within 50 m.
void see_plane(Scan& scan, const Eigen::Vector3f& n, float offset) {
  for (std::size_t i = 0; i < scan.ranges_mm.size(); ++i) {
    const float along = n.dot(scan.geometry->direction_L[i]);
    const float range = (offset - n.dot(scan.geometry->origin_L[i])) / along;
    if (along * offset > 0 && range < 50)
      scan.ranges_mm[i] = static_cast<std::uint32_t>(std::lround(1000 * range));
  }
}

/// Random ranges from 1 m on; one in `lost_in` is lost, none if 0.
void see_noise(Scan& scan, std::uint32_t max_mm, unsigned lost_in) {
  std::mt19937 rng(5);
  std::uniform_int_distribution<std::uint32_t> range_mm(1000, max_mm);
  for (auto& range : scan.ranges_mm)
    range = lost_in != 0 && rng() % lost_in == 0 ? 0 : range_mm(rng);
}

float free_at(const ScanBeams& beams, int row, int column) {
  return beams.image().free_m[static_cast<std::size_t>(row) * beams.image().stride + column];
}

TEST_CASE("a surface is marked behind its return, along the beam, and is free up to there") {
  VoxelConfig config = at_returns(), deeper = config;
  deeper.return_depth_m = 0.04;
  for (const ScanGeometry& geometry : {ring_geometry(1, 0), ring_image_geometry(1, 0)}) {
    Scan scan = empty_scan(geometry);
    scan.ranges_mm[3] = 5000;
    scan.ranges_mm[9] = 59'990;   // its surface is further away than the longest range
    scan.ranges_mm[20] = 60'010;  // this one has none
    ScanBeams measured(64), marked(64);
    CHECK(measured.assign(scan, Pose::Identity(), config) == 0);
    CHECK(marked.assign(scan, Pose::Identity(), deeper) == 0);
    REQUIRE(measured.num_returns() == 2);
    REQUIRE(marked.num_returns() == 2);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3f beam = measured.return_S(i).normalized();
      CHECK((marked.return_S(i) - measured.return_S(i) - 0.04f * beam).norm() < 1e-4f);
    }
    const auto free_m = [&](const ScanBeams& beams) {
      return beams.is_image() ? beams.image().free_m[3] : beams.rays()[0].free_m;
    };
    CHECK(free_m(marked) - free_m(measured) == doctest::Approx(0.04).epsilon(1e-3));
  }
}

TEST_CASE("an image has the returns that beams one by one have") {
  ScanGeometry geometry = geometry_of(wide_sensor());
  Scan scan = empty_scan(geometry);
  scan.ranges_mm.assign(geometry.direction_L.size(), 0);
  see_noise(scan, 70'000, 3);
  scan.column_valid[500] = 0;
  Pose moved(Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.1, 0.2, 0.9).normalized()));
  moved.translation() = Eigen::Vector3d(0.1, -0.05, 0.02);
  scan.poses = {{{0}, Pose::Identity()}, {scan.stamp, moved}};
  Pose T_S_R(Eigen::AngleAxisd(-1.3, Eigen::Vector3d(0.4, -0.2, 0.8).normalized()));
  T_S_R.translation() = Eigen::Vector3d(12, -7, 3);
  ScanBeams image(geometry.direction_L.size()), rays(geometry.direction_L.size());
  CHECK(image.assign(scan, T_S_R, VoxelConfig{}) == 0);
  geometry.projection.reset();
  CHECK(rays.assign(scan, T_S_R, VoxelConfig{}) == 0);
  CHECK(image.is_image());
  CHECK_FALSE(rays.is_image());
  REQUIRE(image.num_returns() == rays.num_returns());
  CHECK(image.num_returns() > 30'000);
  const auto sorted = [](const ScanBeams& beams) {
    std::vector<Eigen::Vector3f> points;
    for (std::size_t i = 0; i < beams.num_returns(); ++i) points.push_back(beams.return_S(i));
    std::sort(points.begin(), points.end(),
              [](const auto& a, const auto& b) { return a.x() < b.x(); });
    return points;
  };
  const std::vector<Eigen::Vector3f> a = sorted(image), b = sorted(rays);
  int num_apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    float nearest = 1;
    for (std::size_t k = i < 50 ? 0 : i - 50; k < std::min(i + 50, b.size()); ++k) {
      nearest = std::min(nearest, (a[i] - b[k]).norm());
    }
    num_apart += nearest > 0.005f;
  }
  CHECK(num_apart == 0);
}

TEST_CASE(
    "a square wall is free up to half a voxel before it, and a slanted one by how far voxels reach "
    "across it") {
  const ScanGeometry geometry = ring_image_geometry(3, 0.05);
  for (const double angle : {0.0, 0.3, std::numbers::pi / 4}) {
    Scan scan = empty_scan(geometry);
    const Eigen::Vector3f n(static_cast<float>(std::cos(angle)),
                            static_cast<float>(std::sin(angle)), 0);
    see_plane(scan, n, 4);
    ScanBeams beams(64 * 3);
    CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
    for (const int column : {0, 3, 60}) {
      const float range = 0.001f * static_cast<float>(scan.ranges_mm[64 + column]);
      const float along = n.dot(geometry.direction_L[64 + column]);
      const float expected =
          0.5f * 0.065f / along * (std::abs(n.x()) + std::abs(n.y()) + 1 - along);
      CHECK(std::abs(range - free_at(beams, 1, column) - expected) < 0.1f * expected);
    }
  }
}

TEST_CASE("a beam that skims a floor proves nothing in the voxel above it") {
  // Rows 2 and 3 degrees below the horizon, 1 m above a floor.
  ScanGeometry geometry = ring_geometry(2, 0);
  for (int column = 0; column < 64; ++column) {
    const double around = -2 * std::numbers::pi * column / 64;
    for (int beam = 0; beam < 2; ++beam) {
      const double up = -(2 + beam) * kDegree;
      geometry.direction_L[beam * 64 + column] =
          Eigen::Vector3d(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                          std::sin(up))
              .cast<float>();
    }
  }
  geometry.projection = fit_projection(2, 64, geometry.direction_L, geometry.origin_L);
  REQUIRE(geometry.projection);
  Scan scan = empty_scan(geometry);
  see_plane(scan, -Eigen::Vector3f::UnitZ(), 1);
  ScanBeams beams(128);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  for (int beam = 0; beam < 2; ++beam) {
    for (int column = 0; column < 64; ++column) {
      const double height_m = 1 - free_at(beams, beam, column) * std::sin((2 + beam) * kDegree);
      CHECK(std::abs(height_m - 0.065) < 0.003);
    }
  }
}

TEST_CASE("an edge says nothing about the slope of what is before it") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  Scan scan = empty_scan(geometry);
  const int row = 30, column = 100, shift = geometry.projection->rows[row].shift;
  const auto range_at = [&](int image_column) -> std::uint32_t& {
    return scan.ranges_mm[row * 1024 + image_column + shift];
  };
  range_at(column) = 3000;
  range_at(column - 1) = range_at(column + 1) =
      40'000;  // further off than any surface seen at half a degree
  ScanBeams beams(geometry.direction_L.size());
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  const float beam_norm = geometry.direction_L[row * 1024 + column + shift].lpNorm<1>();
  const float range_m = 3 - geometry.projection->rows[row].range_offset_m;
  CHECK(range_m - free_at(beams, row, column) ==
        doctest::Approx(0.5 * 0.065 * beam_norm).epsilon(1e-3));
}

TEST_CASE(
    "in an image, lost pixels and near returns prove nothing and far ones free space up to the "
    "longest range") {
  const ScanGeometry geometry = ring_image_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm[0] = 5000;
  scan.ranges_mm[10] = 300;
  scan.ranges_mm[20] = 5000;
  scan.column_valid[20] = 0;
  scan.ranges_mm[30] = 80'000;
  ScanBeams beams(64);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  CHECK(beams.num_returns() == 1);
  CHECK(free_at(beams, 0, 0) == doctest::Approx(5 - 0.5 * 0.065));
  CHECK(free_at(beams, 0, 10) == 0);
  CHECK(free_at(beams, 0, 20) == 0);
  CHECK(free_at(beams, 0, 30) == 60);
}

TEST_CASE("a lost pixel between two others proves what the lesser of them does") {
  const ScanGeometry geometry = ring_image_geometry(3, 0.05);
  Scan scan = empty_scan(geometry);
  scan.ranges_mm.assign(scan.ranges_mm.size(), 5000);
  scan.ranges_mm[64 + 20] = 0;
  scan.ranges_mm[64 + 21] = 4000;
  scan.ranges_mm[64 + 40] = scan.ranges_mm[64 + 41] = 0;
  ScanBeams beams(64 * 3);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  const auto gap = [&](int row, int column) {
    return beams.image().gap_free_m[row * beams.image().stride + column];
  };
  CHECK(free_at(beams, 1, 20) == 0);
  CHECK(gap(1, 19) == doctest::Approx(free_at(beams, 1, 21)));
  CHECK(gap(1, 20) == doctest::Approx(free_at(beams, 1, 21)));
  CHECK(gap(1, 18) > 4.8f);
  for (const int column : {39, 40, 41}) CHECK(gap(1, column) == 0);
}

TEST_CASE("rows run on into the first columns behind their ends") {
  const ScanGeometry geometry = ring_image_geometry(2, 0.05);
  Scan scan = empty_scan(geometry);
  for (std::size_t i = 0; i < scan.ranges_mm.size(); ++i)
    scan.ranges_mm[i] = static_cast<std::uint32_t>(3000 + 7 * i);
  ScanBeams beams(128);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  for (int i = 0; i < RangeImage::kPadding; ++i) {
    for (int row = 0; row < 2; ++row) CHECK(free_at(beams, row, 64 + i) == free_at(beams, row, i));
    CHECK(beams.image().gap_free_m[64 + i] == beams.image().gap_free_m[i]);
  }
}

TEST_CASE("each level of the pyramid bounds the pixels of its cells") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  Scan scan = empty_scan(geometry);
  see_noise(scan, 20'000, 50);
  ScanBeams beams(geometry.direction_L.size());
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  const RangeImage& image = beams.image();
  const int squaring = image.projection->squaring;
  for (int level = 0; level < image.num_levels; ++level) {
    const int cell_columns = 1024 >> (level + squaring);
    REQUIRE(cell_columns >= 2);
    for (int row = 0; row < 64; ++row) {
      for (int column = 0; column < 1024; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(row) * image.stride + column;
        const float free = image.free_m[pixel];
        const float beside =
            std::min(image.free_m[pixel + 1], image.free_m[column > 0 ? pixel - 1 : pixel + 1023]);
        const RangeImage::Bounds& bounds =
            image.pyramid[image.level_begin[level] + (row >> level) * cell_columns +
                          (column >> (level + squaring))];
        REQUIRE(static_cast<float>(bounds.least) * image.unit_m <= (free > 0 ? free : beside));
        REQUIRE(static_cast<float>(bounds.most) * image.unit_m >= free);
        if (row < 63)
          REQUIRE(static_cast<float>(bounds.most_gap) * image.unit_m >= image.gap_free_m[pixel]);
      }
    }
  }
}

TEST_CASE("a gap proves what all four beams around it do") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  Scan scan = empty_scan(geometry);
  see_noise(scan, 20'000, 0);
  ScanBeams beams(geometry.direction_L.size());
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
  for (int row = 0; row + 1 < 64; ++row) {
    for (int column = 0; column < 1024; ++column) {
      const float expected =
          std::min(std::min(free_at(beams, row, column), free_at(beams, row, column + 1)),
                   std::min(free_at(beams, row + 1, column), free_at(beams, row + 1, column + 1)));
      REQUIRE(beams.image().gap_free_m[row * beams.image().stride + column] == expected);
    }
  }
}

TEST_CASE(
    "while the sensor moves, pixels fired at the scan's other end are marked, and columns have "
    "their own poses") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  Pose moved(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  moved.translation() = Eigen::Vector3d(0.08, 0, 0.06);
  for (const bool moves : {true, false}) {
    scan.poses = {{{0}, Pose::Identity()}, {scan.stamp, moves ? moved : Pose::Identity()}};
    ScanBeams beams(geometry.direction_L.size());
    CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 0);
    CHECK(beams.image().turned_rad == doctest::Approx(moves ? 0.1 : 0).epsilon(0.001));
    CHECK(beams.image().moved_m == doctest::Approx(moves ? 0.1 : 0));
    CHECK(beams.image().poses[512].t_S.x() == doctest::Approx(moves ? 0.04 : 0).epsilon(0.01));
    for (int row = 0; row < 64; ++row) {
      const int shift = geometry.projection->rows[row].shift;
      for (int column = 0; column < 1024; ++column) {
        // Fired in column (column + shift) mod 1024: nearer to the scan's other end than the image's column is.
        const bool is_other_end = std::abs((column + shift) % 1024 - column) > 512;
        REQUIRE((free_at(beams, row, column) < 0) == (moves && is_other_end));
      }
    }
  }
}

TEST_CASE("an image that is larger than the capacity is taken beam by beam, as far as they fit") {
  const ScanGeometry geometry = ring_image_geometry(1, 0);
  Scan scan = empty_scan(geometry);
  for (auto& range : scan.ranges_mm) range = 5000;
  ScanBeams beams(10);
  CHECK(beams.assign(scan, Pose::Identity(), at_returns()) == 54);
  CHECK_FALSE(beams.is_image());
  CHECK(beams.num_returns() == 10);
}

}  // namespace
}  // namespace cloister
