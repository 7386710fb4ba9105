#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <doctest/doctest.h>

#include "bench/simulate/plants.hpp"
#include "bench/simulate/walk.hpp"
#include "bench/simulate/world.hpp"
#include "bench/spawning/spawn_walk.hpp"

namespace cloister {
namespace {

constexpr SensorTime kStart{1'000'000'000};
constexpr double kSensorHeightM = 1.2;

SensorModel coarse_sensor(const char* name) {
  SensorModel sensor = make_sensor(name).value();
  sensor.columns = 256;
  return sensor;
}

BoxSolid block(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return BoxSolid::from_corners_m(a, b, 0.5F);
}

/// Floor, ceiling and walls around a rectangle at the origin.
std::vector<BoxSolid> shell(double x_m, double y_m, double height_m) {
  constexpr double kWall = 0.2;
  return {block({-kWall, -kWall, -kWall}, {x_m + kWall, y_m + kWall, 0}),
          block({-kWall, -kWall, height_m}, {x_m + kWall, y_m + kWall, height_m + kWall}),
          block({-kWall, -kWall, 0}, {0, y_m + kWall, height_m}),
          block({x_m, -kWall, 0}, {x_m + kWall, y_m + kWall, height_m}),
          block({0, -kWall, 0}, {x_m, 0, height_m}),
          block({0, y_m, 0}, {x_m, y_m + kWall, height_m})};
}

/// Two furnished rooms of 5 x 4.5 m, one behind the other along x, with a doorway of 0.9 m in the wall between them.
std::vector<BoxSolid> two_rooms() {
  std::vector<BoxSolid> solids = shell(10.15, 4.5, 2.6);
  solids.push_back(block({5.0, 0, 0}, {5.15, 1.8, 2.6}));
  solids.push_back(block({5.0, 2.7, 0}, {5.15, 4.5, 2.6}));
  solids.push_back(block({5.0, 1.8, 2.05}, {5.15, 2.7, 2.6}));
  solids.push_back(block({0.3, 0.2, 0}, {2.1, 1.0, 0.75}));
  solids.push_back(block({0.2, 3.6, 0}, {1.0, 4.4, 1.9}));
  solids.push_back(block({9.2, 0.3, 0}, {10.0, 2.0, 0.75}));
  solids.push_back(block({6.5, 4.0, 0}, {8.5, 4.45, 1.8}));
  return solids;
}

/// Poses of a level sensor at 100 Hz. @param at  (x, y, yaw) after so many seconds
template <typename At>
Trajectory level_walk(double seconds, At&& at) {
  Trajectory walk;
  walk.start = kStart;
  for (int k = 0; k <= static_cast<int>(seconds * 100); ++k) {
    const Eigen::Vector3d x_y_yaw = at(0.01 * k);
    Pose T_W_L = Pose::Identity();
    T_W_L.translation() = Eigen::Vector3d(x_y_yaw.x(), x_y_yaw.y(), kSensorHeightM);
    T_W_L.linear() = Eigen::AngleAxisd(x_y_yaw.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    walk.poses.push_back(T_W_L);
  }
  return walk;
}

/// Two rows of trees and two hedges along a path of `length_m`, on level ground.
TriangleMesh park(double length_m) {
  TriangleMesh mesh =
      union_surface(std::vector<BoxSolid>{block({-25, -25, -0.2}, {length_m + 25, 25, 0})});
  std::vector<ConvexPart> parts;
  RandomStream random = random_stream(1, Purpose::kWorld, 0);
  for (double x = -12; x < length_m + 12; x += 6)
    for (const double y : {-9.0, -3.5, 3.5, 9.0})
      append_tree({x + random.uniform(-1.5, 1.5), y + random.uniform(-0.8, 0.8), 0}, &random, &mesh,
                  &parts);
  append_hedge({-12, -6, 0}, {length_m + 12, -6, 0}, 0.9, 1.2, &random, &mesh, &parts);
  append_hedge({-12, 6, 0}, {length_m + 12, 6, 0}, 0.9, 1.2, &random, &mesh, &parts);
  mesh.albedo.clear();
  return mesh;
}

TEST_CASE("a walk from one room into the next makes two submaps") {
  SpawnWalk walk(coarse_sensor("os0-64"));
  walk.scan_all(union_surface(two_rooms()),
                level_walk(8, [](double t) { return Eigen::Vector3d(1.2 + t, 2.25, 0); }));
  CHECK(walk.submaps().size() == 2);
}

TEST_CASE("turning on the spot begins no submap") {
  SpawnWalk walk(coarse_sensor("os0-64"));
  // Feet that turn a body move it about: 5 cm to all sides.
  walk.scan_all(union_surface(two_rooms()), level_walk(20, [](double t) {
                  return Eigen::Vector3d(2.5 + 0.05 * std::cos(5 * t), 2.2 + 0.05 * std::sin(5 * t),
                                         1.2 * t);
                }));
  CHECK(walk.submaps().size() == 1);
}

TEST_CASE("turning on the spot under trees begins no submap") {
  SpawnWalk walk(coarse_sensor("os1-64"));
  walk.scan_all(park(10), level_walk(10, [](double t) {
                  return Eigen::Vector3d(5 + 0.05 * std::cos(5 * t), 0.05 * std::sin(5 * t),
                                         1.2 * t);
                }));
  CHECK(walk.submaps().size() == 1);
}

TEST_CASE(
    "standing in a doorway, and shifting from one room to the other, begins no chain of submaps") {
  SpawnWalk walk(coarse_sensor("os0-64"));
  // Into the doorway, then to and fro through it, half a metre to each side.
  walk.scan_all(union_surface(two_rooms()), level_walk(27, [](double t) {
                  const double x = t < 3.4 ? 1.7 + t : 5.1 + 0.5 * std::sin(t - 3.4);
                  return Eigen::Vector3d(x, 2.25, 0.5 * std::sin(2 * t));
                }));
  CHECK(walk.submaps().size() <= 2);
}

TEST_CASE("climbing stairs begins no chain of tiny submaps") {
  const World house = make_world("house", 1).value();
  Trajectory truth = walk(house.path, {}, kStart, 1);
  const auto is_above = [&](double height_m) {
    return [&truth, height_m](const Pose& T_W_L) {
      return T_W_L.translation().z() > truth.poses.front().translation().z() + height_m;
    };
  };
  const auto foot = std::find_if(truth.poses.begin(), truth.poses.end(), is_above(0.3));
  const auto head = std::find_if(foot, truth.poses.end(), is_above(2.6));
  REQUIRE(head != truth.poses.end());
  REQUIRE(foot - truth.poses.begin() > 300);
  REQUIRE(truth.poses.end() - head > 300);
  truth.poses = std::vector<Pose>(foot - 300, head + 300);
  SpawnWalk walk(coarse_sensor("os0-64"));
  walk.scan_all(house.mesh, truth);
  CHECK(walk.submaps().size() <= 3);
  CHECK(walk.shortest_submap_m() > 2.5);
}

TEST_CASE("people walking around begin no submap") {
  const std::vector<BoxSolid> hall = shell(14, 10, 3.2);
  const Trajectory truth =
      level_walk(20, [](double t) { return Eigen::Vector3d(5 + 0.2 * t, 5, 0.1 * t); });
  SpawnWalk walk(coarse_sensor("os0-64"));
  for (std::uint64_t k = 0; k < 200; ++k) {
    std::vector<BoxSolid> solids = hall;
    for (int person = 0; person < 16; ++person) {
      // Around the sensor on circles of 1.2 to 4.2 m, half of them against the others, at about a metre a second.
      const double radius_m = 1.2 + 0.2 * person;
      const double angle_rad =
          2.4 * person + (person % 2 == 0 ? 0.1 : -0.1) * static_cast<double>(k) / radius_m;
      const Eigen::Vector3d foot(7 + radius_m * std::cos(angle_rad),
                                 5 + radius_m * std::sin(angle_rad), 0);
      solids.push_back(block(foot + Eigen::Vector3d(-0.22, -0.22, 0.01),
                             foot + Eigen::Vector3d(0.22, 0.22, 1.75)));
    }
    const TriangleMesh mesh_W = union_surface(solids);
    const auto scene_W = RayScene::build(mesh_W);
    REQUIRE(scene_W.has_value());
    walk.scan(mesh_W, *scene_W, truth, k);
  }
  CHECK(walk.submaps().size() == 1);
}

TEST_CASE("a walk through a park begins no chain of tiny submaps") {
  SpawnWalk walk(coarse_sensor("os1-64"));
  walk.scan_all(park(20), level_walk(20, [](double t) {
                  return Eigen::Vector3d(t, 0.4 * std::sin(0.5 * t), 0);
                }));
  CHECK(walk.submaps().size() <= 3);
  CHECK(walk.shortest_submap_m() > 2.5);
}

}  // namespace
}  // namespace cloister
