#include "mapping/integrate/projective.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "mapping/integrate/scene_for_tests.hpp"

namespace cloister {
namespace {

// Scans come ten a second. Sensors stand a metre or so above the floor, at z = 0.

/// A sensor that somebody holds: it sways by a quarter of a metre and two degrees.
Pose swaying(double seconds) {
  Pose T(Eigen::AngleAxisd(0.035 * std::sin(1.3 * seconds), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(0.035 * std::sin(1.7 * seconds + 1), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(0.3 * std::sin(0.9 * seconds), Eigen::Vector3d::UnitZ()));
  T.translation() = Eigen::Vector3d(0.1 * std::sin(0.7 * seconds), 0.25 * std::sin(0.5 * seconds),
                                    0.05 * std::sin(1.1 * seconds));
  return T;
}
Motion swaying_from(int scan) {
  return [scan](double seconds) { return swaying(0.1 * scan + seconds); };
}

TEST_CASE("a door frame keeps its edges and the doorway becomes free") {
  Scene scene;
  scene.add_room({-3, -4, -1.2f}, {6.5f, 4, 1.6f});
  scene.boxes.push_back({{3.02f, -4, -1.2f}, {3.14f, -0.45f, 1.6f}});
  scene.boxes.push_back({{3.02f, 0.45f, -1.2f}, {3.14f, 4, 1.6f}});
  scene.boxes.push_back({{3.02f, -0.45f, 0.8f}, {3.14f, 0.45f, 1.6f}});
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    SceneMap map(geometry);
    VoxelSet jambs, lintel;
    for (int scan = 0; scan < 30; ++scan) {
      map.integrate(see(scene, geometry, swaying_from(scan)));
      map.add_hit_voxels({2.9f, 0.40f, -1.1f}, {3.16f, 0.52f, 0.75f}, jambs);
      map.add_hit_voxels({2.9f, -0.52f, -1.1f}, {3.16f, -0.40f, 0.75f}, jambs);
      map.add_hit_voxels({2.9f, -0.45f, 0.75f}, {3.16f, 0.45f, 0.9f}, lintel);
    }
    const VoxelSet doorway = map.voxels_in({2.95f, -0.37f, -0.7f}, {3.2f, 0.37f, 0.7f});
    MESSAGE("jambs " << jambs.size() << " " << map.share(jambs, VoxelState::kOccupied));
    MESSAGE("lintel " << lintel.size() << " " << map.share(lintel, VoxelState::kOccupied));
    MESSAGE("doorway " << doorway.size() << " " << map.share(doorway, VoxelState::kFree) << " occ "
                       << map.share(doorway, VoxelState::kOccupied));
  }
}

TEST_CASE("table legs of 4 cm survive a hundred scans from one to four metres") {
  Scene scene;
  scene.add_room({-6, -6, -0.7f}, {6, 6, 2});
  for (int leg = 0; leg < 4; ++leg) {
    const double around = 0.4 + 1.5 * leg;
    const Eigen::Vector3f middle(static_cast<float>((1 + leg) * std::cos(around)),
                                 static_cast<float>((1 + leg) * std::sin(around)), -0.35f);
    const Eigen::Vector3f half(0.02f, 0.02f, 0.35f);
    scene.boxes.push_back({middle - half, middle + half});
  }
  for (const bool sways : {true, false}) {
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    SceneMap map(geometry);
    std::array<VoxelSet, 4> legs;
    for (int scan = 0; scan < 100; ++scan) {
      map.integrate(see(scene, geometry, sways ? swaying_from(scan) : standing(swaying(0.3))));
      for (int leg = 0; leg < 4; ++leg) {
        const Scene::Box& box = scene.boxes[6 + leg];
        const Eigen::Vector3f margin(0.005f, 0.005f, 0);
        map.add_hit_voxels(box.low - margin + Eigen::Vector3f(0, 0, 0.1f), box.high + margin, legs[leg]);
      }
    }
    for (int leg = 0; leg < 4; ++leg) {
      MESSAGE("leg " << leg << " sways " << sways << " " << legs[leg].size() << " " << map.share(legs[leg], VoxelState::kOccupied));
    }
  }
  }
}

TEST_CASE("railings of 4 cm bars stay occupied from two to five metres") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  for (const float distance : {2.0f, 3.5f, 5.0f}) {
    Scene scene;
    scene.add_room({-4, -5, -1.2f}, {9, 5, 1.6f});
    for (int bar = -12; bar <= 12; ++bar) {
      const Eigen::Vector3f middle(distance, 0.12f * static_cast<float>(bar), -0.7f);
      scene.boxes.push_back({middle - Eigen::Vector3f(0.02f, 0.02f, 0.5f), middle + Eigen::Vector3f(0.02f, 0.02f, 0.5f)});
    }
    SceneMap map(geometry);
    VoxelSet bars;
    for (int scan = 0; scan < 50; ++scan) {
      map.integrate(see(scene, geometry, swaying_from(scan)));
      map.add_hit_voxels({distance - 0.025f, -1.5f, -1.1f}, {distance + 0.025f, 1.5f, -0.2f}, bars);
    }
    MESSAGE("bars at " << distance << " " << bars.size() << " " << map.share(bars, VoxelState::kOccupied));
  }
}

TEST_CASE("a floor seen at two degrees stays occupied for five hundred scans") {
  // The rows that see the floor, of a sensor half a metre above it.
  const ScanGeometry geometry = geometry_of(staggered_sensor(24, 0.2, -12, 3.1, 512));
  for (const float height : {0.47f, 0.50f, 0.515f}) {
    Scene scene;
    scene.boxes.push_back({{-60, -60, -1}, {60, 60, -height}});
    SceneMap map(geometry);
    VoxelSet grazed, all;
    for (int scan = 0; scan < 500; ++scan) {
      const Motion motion = [scan](double seconds) {
        const double time = 0.1 * scan + seconds;
        Pose T(Eigen::AngleAxisd(0.003 * std::sin(1.3 * time), Eigen::Vector3d::UnitX()));
        T.translation().x() = 0.04 * time;
        return T;
      };
      map.integrate(see(scene, geometry, motion));
      map.add_hit_voxels({11.5f, -8, -1}, {19, 8, 0}, grazed);
      map.add_hit_voxels({3, -8, -1}, {25, 8, 0}, all);
    }
    MESSAGE("floor " << grazed.size() << " " << map.share(grazed, VoxelState::kOccupied) << " all " << all.size() << " "
                     << map.share(all, VoxelState::kOccupied));
  }
}

TEST_CASE("a person who leaves is free again within a second of being seen through") {
  Scene room;
  room.add_room({-3, -4, -1.2f}, {7, 4, 1.6f});
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    for (const bool sways : {true, false}) {
    for (const float distance : {1.5f, 3.0f, 5.0f}) {
      Scene scene = room;
      scene.cylinders.push_back({{distance, 0.4f}, 0.25f, -1.2f, 0.5f});
      SceneMap map(geometry);
      VoxelSet person;
      int scan = 0;
      for (; scan < 20; ++scan) {
        map.integrate(see(scene, geometry, sways ? swaying_from(scan) : standing(swaying(0.3))));
        map.add_hit_voxels({distance - 0.26f, 0.1f, -1.1f}, {distance + 0.26f, 0.7f, 0.55f}, person);
      }
      const double before = map.share(person, VoxelState::kOccupied);
      const std::size_t blocks_before = map.volume.num_blocks();
      for (; scan < 30; ++scan) map.integrate(see(room, geometry, sways ? swaying_from(scan) : standing(swaying(0.3))));
      std::size_t blocks_left = 0, blocks = 0;
      for (const auto& [x, y, z] : map.voxels_in({distance - 0.3f, 0.1f, -0.6f}, {distance + 0.3f, 0.7f, 0.55f})) {
        if ((x & 7) != 0 || (y & 7) != 0 || (z & 7) != 0) continue;
        ++blocks;
        blocks_left += map.volume.view(map.store, {x >> 3, y >> 3, z >> 3}).block != nullptr;
      }
      MESSAGE("person at " << distance << " sways " << sways << ": " << person.size() << " before " << before << " after "
                           << map.share(person, VoxelState::kOccupied) << " blocks " << blocks_before << " -> "
                           << map.volume.num_blocks() << " left " << blocks_left << " of " << blocks);
    }
    }
  }
}

TEST_CASE("the ground under the robot stays occupied") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  Scene scene;
  scene.add_room({-4, -4, -0.6f}, {8, 4, 2});
  SceneMap map(geometry);
  VoxelSet ground;
  for (int scan = 0; scan < 40; ++scan) {
    map.integrate(see(scene, geometry, [scan](double seconds) { return upright_pose(0.1 * scan + seconds, 0, 0); }));
    map.add_hit_voxels({0, -1, -0.7f}, {4, 1, -0.5f}, ground);
  }
  MESSAGE("ground " << ground.size() << " " << map.share(ground, VoxelState::kOccupied));
}

}  // namespace
}  // namespace cloister
