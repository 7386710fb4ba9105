#include "bench/simulate/house.hpp"

#include <algorithm>

#include <doctest/doctest.h>

#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "bench/simulate/visits_for_tests.hpp"
#include "bench/simulate/walk.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'000'000'000};

TEST_CASE("the house has at least six rooms on two storeys and each is entered at least twice") {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    CAPTURE(seed);
    const World house = make_house(seed);
    const Trajectory truth = walk(house.path, WalkConfig{}, kStart, seed);
    CHECK(house.rooms.size() >= 6);
    CHECK(std::any_of(house.rooms.begin(), house.rooms.end(),
                      [](const Room& r) { return r.storey == 1; }));
    for (const Room& room : house.rooms) {
      CAPTURE(room.name);
      CHECK(visits(room, truth) >= 2);
    }
  }
}

TEST_CASE("the sensor keeps its distance from everything solid on the whole way") {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    CAPTURE(seed);
    const World house = make_house(seed);
    const Trajectory truth = walk(house.path, WalkConfig{}, kStart, seed);
    double nearest = 1e9;
    for (const Pose& pose : truth.poses) {
      for (const BoxSolid& solid : house.solids)
        nearest = std::min(nearest, solid.distance_m(pose.translation()));
    }
    CHECK(nearest > 0.3);
  }
}

TEST_CASE("the walk is smooth, as fast as a person, and turns no faster than allowed") {
  const World house = make_house(1);
  const WalkConfig config;
  const Trajectory truth = walk(house.path, config, kStart, 1);
  double fastest = 0.0;
  double most_turn = 0.0;
  for (std::size_t k = 1; k < truth.poses.size(); ++k) {
    const Pose step = truth.poses[k - 1].inverse() * truth.poses[k];
    fastest = std::max(fastest, step.translation().norm() / 0.01);
    most_turn = std::max(most_turn, Eigen::AngleAxisd(step.linear()).angle() / 0.01);
  }
  CHECK(fastest < 1.2 * config.speed_mps);
  CHECK(most_turn < config.max_yaw_rate_radps + 0.7);  // the shake turns too
  const double seconds = (truth.end() - truth.start).seconds();
  CHECK(seconds > 120.0);
  CHECK(seconds < 240.0);
}

TEST_CASE("the house's surface bounds exactly its solids") {
  const World house = make_house(2);
  const auto scene = RayScene::build(house.mesh);
  REQUIRE(scene);
  CHECK(house.mesh.albedo.size() == house.mesh.triangles.size());
  RandomStream random(1, 1);
  int compared = 0;
  for (int k = 0; k < 4000; ++k) {
    const Eigen::Vector3d p(random.uniform(-0.5, 12.7), random.uniform(-0.5, 10.5),
                            random.uniform(-0.5, 6.0));
    if (scene->distance(p.cast<float>(), 1.0F) < 1e-3F) continue;
    ++compared;
    CHECK(scene->is_inside(p.cast<float>()) == house.is_solid(p));
  }
  CHECK(compared > 3500);
}

TEST_CASE("the seed changes doors, furniture and path, and nothing else does") {
  const World a = make_house(1);
  const World again = make_house(1);
  const World b = make_house(2);
  CHECK(a.mesh.vertices == again.mesh.vertices);
  CHECK(a.mesh.vertices != b.mesh.vertices);
  CHECK(a.path[5].position_W == again.path[5].position_W);
  CHECK(a.path[5].position_W != b.path[5].position_W);
}

TEST_CASE("rooms of different storeys and rooms behind walls do not see each other") {
  const World house = make_house(1);
  const auto scene = RayScene::build(house.mesh);
  REQUIRE(scene);
  const Eigen::Vector3f kitchen(3.0F, 0.6F, 2.3F);
  CHECK_FALSE(scene->line_of_sight(kitchen, {3.0F, 0.6F, 5.0F}));
  CHECK_FALSE(scene->line_of_sight(kitchen, {9.0F, 9.0F, 2.3F}));
}

}  // namespace
}  // namespace cloister
