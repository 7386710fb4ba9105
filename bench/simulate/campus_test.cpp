#include "bench/simulate/campus.hpp"

#include <algorithm>

#include <doctest/doctest.h>

#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "bench/simulate/scan_simulator.hpp"
#include "bench/simulate/walk.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'000'000'000};

TEST_CASE("the campus is walked for 2.2 km in 44 minutes, 1.2 m above its ground, clear of all") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const World campus = make_campus(seed);
    const Trajectory truth = walk(campus.path, WalkConfig{}, kStart, seed);
    const auto scene = RayScene::build(campus.mesh);
    REQUIRE(scene);
    double length = 0.0;
    float nearest = 10.0F;
    for (std::size_t k = 10; k < truth.poses.size(); k += 10) {
      const Eigen::Vector3d p = truth.poses[k].translation();
      length += (p - truth.poses[k - 10].translation()).norm();
      nearest = std::min(nearest, scene->distance(p.cast<float>(), nearest));
      REQUIRE(p.z() - campus.ground->at(p.x(), p.y()) == doctest::Approx(1.2).epsilon(0.05));
    }
    CHECK(nearest > 0.8F);
    CHECK(length == doctest::Approx(2200.0).epsilon(0.03));
    CHECK((truth.end() - truth.start).seconds() == doctest::Approx(44 * 60).epsilon(0.03));
  }
}

TEST_CASE("the walk comes back to the quad, the tunnel and the park several times") {
  const World campus = make_campus(1);
  const Trajectory truth = walk(campus.path, WalkConfig{}, kStart, 1);
  const auto visits = [&](const char* name) {
    const auto area = std::find_if(campus.rooms.begin(), campus.rooms.end(),
                                   [&](const Room& r) { return r.name == name; });
    REQUIRE(area != campus.rooms.end());
    int count = 0;
    bool was_inside = false;
    for (const Pose& pose : truth.poses) {
      const bool is_inside = area->contains(pose.translation(), was_inside ? 0.0 : 0.3);
      count += is_inside && !was_inside ? 1 : 0;
      was_inside = is_inside;
    }
    return count;
  };
  CHECK(visits("quad") == 6);
  CHECK(visits("tunnel") == 10);
  CHECK(visits("park") == 5);
  CHECK(visits("north street") == 1);
  CHECK(visits("south street") == 1);
}

TEST_CASE(
    "crossings of the campus's mesh and its solids, parts and ground agree on what is solid") {
  const World campus = make_campus(2);
  const auto scene = RayScene::build(campus.mesh);
  REQUIRE(scene);
  CHECK(campus.mesh.albedo.size() == campus.mesh.triangles.size());
  CHECK(campus.mesh.triangles.size() < 1'500'000);
  RandomStream random(1, 1);
  int solid = 0;
  const auto compare = [&](const Eigen::Vector3d& p) {
    if (scene->distance(p.cast<float>(), 1.0F) < 1e-3F) return;
    const bool expected = campus.is_solid(p);
    solid += expected ? 1 : 0;
    CHECK(scene->is_inside(p.cast<float>()) == expected);
  };
  for (int k = 0; k < 1000; ++k) {
    compare({random.uniform(0.0, 135.0), random.uniform(0.0, 122.0), random.uniform(-1.0, 15.0)});
  }
  for (int k = 0; k < 300; ++k) {  // inside trunks and branches, and close to leaves
    const ConvexPart& part = campus.parts[random.below(campus.parts.size())];
    const Eigen::Vector3f share(static_cast<float>(random.uniform()),
                                static_cast<float>(random.uniform()),
                                static_cast<float>(random.uniform()));
    compare((part.min + share.cwiseProduct(part.max - part.min)).cast<double>());
  }
  CHECK(solid > 300);
}

TEST_CASE("the ground is uneven by half a metre, nothing is higher than 15 m") {
  const World campus = make_campus(3);
  const auto& z = campus.ground->height_m;
  const auto [low, high] = std::minmax_element(z.begin(), z.end());
  CHECK(*low > -0.51F);
  CHECK(*high < 0.51F);
  CHECK(*high - *low > 0.6F);
  float top = 0.0F;
  for (const Eigen::Vector3f& v : campus.mesh.vertices) top = std::max(top, v.z());
  CHECK(top <= 15.0F);
  CHECK(top > 12.0F);
}

TEST_CASE("crowns let some beams through and hold others") {
  const World campus = make_campus(1);
  const auto scene = RayScene::build(campus.mesh);
  REQUIRE(scene);
  RandomStream random(4, 1);
  int blocked = 0;
  int open = 0;
  for (const ConvexPart& part : campus.parts) {
    // Trunks: eight sides and two lids, standing in the ground.
    if (part.num_triangles != 28) continue;
    const Eigen::Vector3f top(0.5F * (part.min.x() + part.max.x()),
                              0.5F * (part.min.y() + part.max.y()), part.max.z());
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3f aside(static_cast<float>(random.uniform(-1.5, 1.5)),
                                  static_cast<float>(random.uniform(-1.5, 1.5)), 0.0F);
      const Eigen::Vector3f up(0.0F, 0.0F, 8.0F);
      ++(scene->line_of_sight(top + aside - 0.25F * up, top + aside + up) ? open : blocked);
    }
  }
  CHECK(open + blocked > 900);
  CHECK(open > (open + blocked) / 10);
  CHECK(blocked > (open + blocked) / 4);
}

TEST_CASE("the campus's seed changes ground, houses, trees and path, and nothing else does") {
  const World a = make_campus(1);
  const World again = make_campus(1);
  const World b = make_campus(2);
  CHECK(a.mesh.vertices == again.mesh.vertices);
  CHECK(a.mesh.vertices != b.mesh.vertices);
  CHECK(a.ground->height_m != b.ground->height_m);
  CHECK(a.path[5].position_W == again.path[5].position_W);
  CHECK(a.path[5].position_W != b.path[5].position_W);
}

TEST_CASE("a scan of the campus reaches far and is made by the sensor that the world names") {
  const World campus = make_campus(1);
  const auto scene = RayScene::build(campus.mesh);
  REQUIRE(scene);
  const auto sensor = make_sensor(campus.sensor);
  REQUIRE(sensor);
  CHECK(sensor->name == "os1-64");
  const Trajectory truth = walk(campus.path, WalkConfig{}, kStart, 1);
  const ScanSimulator simulator(*sensor, campus.mesh, *scene, 1);
  std::vector<PixelReturn> pixels(simulator.num_pixels());
  std::size_t returns = 0;
  std::size_t far = 0;
  for (const std::uint64_t scan : {100U, 3000U, 8000U, 15'000U}) {
    simulator.simulate(truth, truth.start, scan, pixels);
    for (const PixelReturn& pixel : pixels) {
      returns += pixel.range_mm > 0 ? 1 : 0;
      far += pixel.range_mm > 20'000 ? 1 : 0;
    }
  }
  CHECK(returns > 4 * pixels.size() * 3 / 4);
  CHECK(far > returns / 10);
}

}  // namespace
}  // namespace cloister
