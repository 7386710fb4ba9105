#include <algorithm>
#include <map>
#include <string>

#include <doctest/doctest.h>

#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "bench/simulate/visits_for_tests.hpp"
#include "bench/simulate/walk.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'000'000'000};

Trajectory walk_through(const World& world, std::uint64_t seed) {
  return walk(world.path, WalkConfig{}, kStart, seed);
}

double length_of(const Trajectory& truth) {
  double length = 0.0;
  for (std::size_t k = 1; k < truth.poses.size(); ++k)
    length += (truth.poses[k].translation() - truth.poses[k - 1].translation()).norm();
  return length;
}

/// What holds for every network of rooms: built of boxes whose surface is the mesh, a way that
/// touches nothing and never leaves the rooms and stairs.
void check_world(const char* name, std::uint64_t seed) {
  CAPTURE(name);
  CAPTURE(seed);
  const auto world = make_world(name, seed);
  REQUIRE(world);
  CHECK(world->name == name);
  CHECK(world->sensor == "os0-64");
  CHECK(world->mesh.albedo.size() == world->mesh.triangles.size());
  const auto scene = RayScene::build(world->mesh);
  REQUIRE(scene);

  const Trajectory truth = walk_through(*world, seed);
  float nearest = 10.0F;
  for (std::size_t k = 0; k < truth.poses.size(); k += 5) {
    const Eigen::Vector3d p = truth.poses[k].translation();
    nearest = std::min(nearest, scene->distance(p.cast<float>(), nearest));
    if (k % 100 == 0) REQUIRE_FALSE(world->is_solid(p));
  }
  CHECK(nearest > 0.3F);

  Eigen::Vector3d low = world->rooms.front().min_W;
  Eigen::Vector3d high = low;
  for (const Room& room : world->rooms) {
    low = low.cwiseMin(room.min_W);
    high = high.cwiseMax(room.max_W);
  }
  RandomStream random(seed, 1);
  int disagreements = 0;
  int compared = 0;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d share(random.uniform(-0.05, 1.05), random.uniform(-0.05, 1.05),
                                random.uniform(-0.05, 1.05));
    const Eigen::Vector3d p = low + share.cwiseProduct(high - low);
    if (scene->distance(p.cast<float>(), 1.0F) < 1e-3F) continue;
    ++compared;
    disagreements += scene->is_inside(p.cast<float>()) == world->is_solid(p) ? 0 : 1;
  }
  CHECK(disagreements == 0);
  CHECK(compared > 1800);

  const auto again = make_world(name, seed);
  const auto other = make_world(name, seed + 1);
  REQUIRE(again);
  REQUIRE(other);
  CHECK(world->mesh.vertices == again->mesh.vertices);
  CHECK(world->mesh.vertices != other->mesh.vertices);
  CHECK(world->path[3].position_W == again->path[3].position_W);
  CHECK(world->path[3].position_W != other->path[3].position_W);
}

TEST_CASE("the small rooms are solid where their mesh says so, and walked without touching") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) check_world("small-rooms", seed);
}

TEST_CASE("six rounds lead through all nine small rooms, three in each direction") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const auto world = make_world("small-rooms", seed);
    REQUIRE(world);
    REQUIRE(world->rooms.size() == 9);
    const Trajectory truth = walk_through(*world, seed);
    std::string order;  // of the rooms entered, by their first letters
    const Room* last = nullptr;
    for (const Pose& pose : truth.poses) {
      for (const Room& room : world->rooms) {
        if (&room == last || !room.contains(pose.translation(), 0.3)) continue;
        order += room.name[0];
        last = &room;
      }
    }
    CHECK(order == "ABCDEFGHmBABCDEFGHmBABCDEFGHmBABmHGFEDCBABmHGFEDCBABmHGFEDCBA");
    for (const Room& room : world->rooms) {
      CHECK(visits(room, truth) >= 6);
      const Eigen::Vector3d size = room.max_W - room.min_W;
      CHECK(size.head<2>().minCoeff() > 3.7);
      CHECK(size.head<2>().maxCoeff() < 5.0);
    }
  }
}

TEST_CASE("the three storeys are solid where their mesh says so, and walked without touching") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) check_world("three-storey", seed);
}

TEST_CASE("every room of the three storeys is visited, and the way ends where it began") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const auto world = make_world("three-storey", seed);
    REQUIRE(world);
    const Trajectory truth = walk_through(*world, seed);
    std::map<int, int> rooms_of_storey;
    for (const Room& room : world->rooms) {
      CAPTURE(room.name);
      CHECK(visits(room, truth) >= 1);
      ++rooms_of_storey[room.storey];
    }
    CHECK(rooms_of_storey == std::map<int, int>{{-1, 6}, {0, 10}, {1, 10}});
    const Eigen::Vector3d gap =
        truth.poses.back().translation() - truth.poses.front().translation();
    CHECK(gap.norm() < 0.3);
  }
}

TEST_CASE("the large rooms are solid where their mesh says so, and walked without touching") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) check_world("large-rooms", seed);
}

TEST_CASE("700 m lead through all large rooms and back to the middle hall ten times") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const auto world = make_world("large-rooms", seed);
    REQUIRE(world);
    CHECK(world->rooms.size() == 49);
    const Trajectory truth = walk_through(*world, seed);
    CHECK(length_of(truth) == doctest::Approx(700.0).epsilon(0.05));
    int halls = 0;
    for (const Room& room : world->rooms) {
      CAPTURE(room.name);
      // It begins in the middle hall, which is no way of coming back to it.
      CHECK(visits(room, truth) >= (room.name == "middle hall" ? 11 : 1));
      const Eigen::Vector3d size = room.max_W - room.min_W;
      halls += size.x() > 11.8 && size.x() < 12.0 && size.y() > 17.8 ? 1 : 0;
    }
    CHECK(halls == 3);
  }
}

}  // namespace
}  // namespace cloister
