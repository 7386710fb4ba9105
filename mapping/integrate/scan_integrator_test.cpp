#include "mapping/integrate/scan_integrator.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>
#include <tuple>

namespace cloister {
namespace {

struct Fixture {
  explicit Fixture(std::size_t blocks = 20'000, std::size_t chunks = 2'000)
      : store(blocks, chunks), pools(store), integrator(config) {
    pools.take_all();
  }
  /// Integrates points seen from `origin` as one cloud.
  IntegrationResult integrate(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& origin) {
    Scan scan;
    scan.kind = Scan::Kind::kCloud;
    scan.points_L = points;
    Pose T_R_L = Pose::Identity();
    T_R_L.translation() = origin.cast<double>();
    scan.poses = {{{0}, T_R_L}};
    ScanBeams beams(points.size());
    REQUIRE(beams.assign(scan, Pose::Identity(), config) == 0);
    return integrator.integrate(beams, origin, pools, volume);
  }
  [[nodiscard]] LogOdds at(const Eigen::Vector3f& p) const {
    const Eigen::Vector3f v = p / static_cast<float>(config.voxel_size_m);
    return volume.at(store, {static_cast<int>(std::floor(v.x())), static_cast<int>(std::floor(v.y())),
                             static_cast<int>(std::floor(v.z()))});
  }
  VoxelConfig config;
  VoxelStore store;
  VoxelPools pools;
  ScanIntegrator integrator;
  Volume volume;
};

TEST_CASE("a return is occupied, the way to it is free, behind it nothing is known") {
  Fixture f;
  f.integrate({{5, 0.01f, 0.01f}}, {0, 0, 0});
  CHECK(f.at({5, 0.01f, 0.01f}) == 17);
  CHECK(f.at({2.5f, 0.005f, 0.005f}) == -8);
  CHECK(f.at({5.5f, 0.01f, 0.01f}) == kUnknownLogOdds);
  CHECK(f.at({2.5f, 0.2f, 0}) == kUnknownLogOdds);
}

TEST_CASE("voxels on the way agree with densely sampled rays") {
  Fixture f;
  const unsigned seed = 11;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> coordinate(-8, 8);
  const Eigen::Vector3f origin(0.3f, -0.2f, 0.1f);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(coordinate(rng), coordinate(rng), coordinate(rng));
  f.integrate(points, origin);
  int num_checked = 0;
  for (const Eigen::Vector3f& point : points) {
    const float range = point.norm();
    for (float s = 0.02f; s < range - 0.15f; s += 0.013f) {
      // Samples close to a voxel's border may fall to either side.
      const Eigen::Vector3f p = (origin + point * (s / range)) / 0.065f;
      const Eigen::Vector3f frac = p.array() - p.array().floor();
      if (frac.minCoeff() < 0.02f || frac.maxCoeff() > 0.98f) continue;
      ++num_checked;
      CHECK(f.at(p * 0.065f) != kUnknownLogOdds);
    }
    CHECK(f.at(origin + point) > 0);
  }
  CHECK(num_checked > 10'000);
}

TEST_CASE("a scan updates a voxel once, however many of its beams pass") {
  Fixture f;
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 50; ++i) points.emplace_back(5.0f, 0.001f * static_cast<float>(i), 0.01f);
  f.integrate(points, {0.03f, 0.001f, 0.01f});
  CHECK(f.at({0.2f, 0.001f, 0.01f}) == -8);
}

TEST_CASE("a voxel that one beam hits and another crosses counts as hit") {
  Fixture f;
  f.integrate({{2.0f, 0.01f, 0.01f}, {4.0f, 0.02f, 0.02f}}, {0, 0, 0});
  CHECK(f.at({2.0f, 0.01f, 0.01f}) == 17);
}

TEST_CASE("an object that has left is free again after a second of being seen through") {
  Fixture f;
  for (int i = 0; i < 20; ++i) f.integrate({{3.0f, 0.01f, 0.01f}}, {0, 0, 0});
  CHECK(f.at({3.0f, 0.01f, 0.01f}) == 70);
  for (int i = 0; i < 10; ++i) f.integrate({{6.0f, 0.02f, 0.02f}}, {0, 0, 0});
  CHECK(f.at({3.0f, 0.01f, 0.01f}) < 0);
}

TEST_CASE("free space that is seen everywhere returns its blocks to the pool") {
  Fixture f;
  std::vector<Eigen::Vector3f> wall;
  for (float y = -3; y <= 3; y += 0.03f) {
    for (float z = -3; z <= 3; z += 0.03f) wall.emplace_back(4.0f, y, z);
  }
  for (int i = 0; i < 3; ++i) f.integrate(wall, {0, 0, 0});
  const BlockView view = f.volume.view(f.store, {3, 0, 0});
  CHECK(view.block == nullptr);
  CHECK(view.known == kAllOctants);
  CHECK(view.coarse < 0);
}

TEST_CASE("full pools decline updates, count them, and keep what is there") {
  Fixture f(4, 4);
  f.integrate({{1.0f, 0.01f, 0.01f}}, {0, 0, 0});
  const LogOdds before = f.at({1.0f, 0.01f, 0.01f});
  const IntegrationResult result = f.integrate({{30.0f, 0.5f, 0.2f}}, {0, 0, 0});
  CHECK(result.voxels_declined > 100);
  CHECK(before == 17);
  CHECK(f.at({1.0f, 0.01f, 0.01f}) > 0);
}

TEST_CASE("evidence that cancels keeps the voxel known") {
  CHECK(add_log_odds(8, -8, -40, 70) == -1);
  CHECK(add_log_odds(-17, 17, -40, 70) == 1);
  CHECK(add_log_odds(-40, -8, -40, 70) == -40);
  CHECK(add_log_odds(69, 17, -40, 70) == 70);
}

}  // namespace
}  // namespace cloister
