#include "mapping/integrate/projective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/integrate/scene_for_tests.hpp"

namespace cloister {
namespace {

// Scans come ten a second. Sensors are at z = 0 or near it, half a metre to 1.2 m above the floor.

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

Scene::Box upright_bar(const Eigen::Vector3f& middle, float width, float height) {
  const Eigen::Vector3f half(0.5f * width, 0.5f * width, 0.5f * height);
  return {middle - half, middle + half};
}

TEST_CASE("a door frame keeps its edges and the doorway becomes free") {
  Scene scene;
  scene.add_room({-3, -4, -1.2f}, {6.5f, 4, 1.6f});
  scene.boxes.push_back({{3.02f, -4, -1.2f}, {3.14f, -0.45f, 1.6f}});
  scene.boxes.push_back({{3.02f, 0.45f, -1.2f}, {3.14f, 4, 1.6f}});
  scene.boxes.push_back({{3.02f, -0.45f, 0.8f}, {3.14f, 0.45f, 1.6f}});
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    CAPTURE(sensor.ring_radius_m);
    const ScanGeometry geometry = geometry_of(sensor);
    SceneMap map(geometry);
    VoxelSet left, right, wall;
    std::vector<VoxelSet> lintel_by_scan(30);
    for (int scan = 0; scan < 30; ++scan) {
      map.integrate(see(scene, geometry, swaying_from(scan)));
      map.add_hit_voxels({2.9f, 0.40f, -1.1f}, {3.16f, 0.52f, 0.75f}, left);
      map.add_hit_voxels({2.9f, -0.52f, -1.1f}, {3.16f, -0.40f, 0.75f}, right);
      map.add_hit_voxels({2.9f, -0.45f, 0.75f}, {3.16f, 0.45f, 0.9f}, lintel_by_scan[scan]);
      map.add_hit_voxels({2.9f, 0.52f, -1.1f}, {3.16f, 3.5f, 1.4f}, wall);
    }
    CHECK(map.share_of_layers(left) == 1);
    CHECK(map.share_of_layers(right) == 1);
    // Its underside is skimmed: voxels that a tenth of the scans hit are its edge, others are crossed more often than hit.
    VoxelSet lintel;
    for (const VoxelSet& hit : lintel_by_scan) {
      hit.for_each([&](const VoxelCoord& v) {
        const auto num_hits = std::count_if(lintel_by_scan.begin(), lintel_by_scan.end(),
                                            [&](const VoxelSet& set) { return set.contains(v); });
        if (num_hits >= 3) lintel.insert(v);
      });
    }
    CHECK(map.share_standing(lintel, {1, 0, 0}) > 0.95);
    CHECK(map.share(wall, VoxelState::kOccupied) > 0.99);
    CHECK(map.share(map.voxels_in({2.95f, -0.37f, -0.7f}, {3.2f, 0.37f, 0.7f}), VoxelState::kFree) >
          0.995);
  }
}

TEST_CASE("table legs of 4 cm survive a hundred scans from one to four metres" *
          doctest::test_suite("slow")) {
  Scene scene;
  scene.add_room({-6, -6, -0.7f}, {6, 6, 2});
  const std::size_t first_leg = scene.boxes.size();
  for (int leg = 0; leg < 4; ++leg) {
    const double around = 0.4 + 1.5 * leg;
    const Eigen::Vector2f middle =
        (Eigen::Vector2d(std::cos(around), std::sin(around)) * (1 + leg)).cast<float>();
    scene.boxes.push_back(upright_bar({middle.x(), middle.y(), -0.35f}, 0.04f, 0.7f));
  }
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    CAPTURE(sensor.ring_radius_m);
    const ScanGeometry geometry = geometry_of(sensor);
    for (const bool sways : {true, false}) {
      SceneMap map(geometry);
      std::array<VoxelSet, 4> legs;
      for (int scan = 0; scan < 100; ++scan) {
        map.integrate(see(scene, geometry, sways ? swaying_from(scan) : standing(swaying(0.3))));
        for (int leg = 0; leg < 4; ++leg) {
          const Scene::Box& box = scene.boxes[first_leg + leg];
          // Where all scans see it: not at the border of the field of view.
          const float low_z = std::max(-0.6f, -0.2f * static_cast<float>(1 + leg));
          const Eigen::Vector3f margin(0.005f, 0.005f, -0.02f);
          map.add_hit_voxels({box.low.x() - 0.005f, box.low.y() - 0.005f, low_z}, box.high + margin,
                             legs[leg]);
        }
      }
      for (int leg = 0; leg < 4; ++leg) {
        CAPTURE(leg);
        CHECK(legs[leg].size() > 3);
        CHECK(map.share_of_layers(legs[leg]) == 1);
        CHECK(map.share(legs[leg], VoxelState::kOccupied) > 0.85);
      }
    }
  }
}

TEST_CASE("railings of 4 cm bars stay occupied from two to five metres" *
          doctest::test_suite("slow")) {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  for (const float distance : {2.0f, 3.5f, 5.0f}) {
    CAPTURE(distance);
    Scene scene;
    scene.add_room({-4, -5, -1.2f}, {9, 5, 1.6f});
    const std::size_t first_bar = scene.boxes.size();
    for (int bar = -12; bar <= 12; ++bar) {
      scene.boxes.push_back(
          upright_bar({distance, 0.12f * static_cast<float>(bar), -0.7f}, 0.04f, 1));
    }
    SceneMap map(geometry);
    std::vector<VoxelSet> bars(25);
    for (int scan = 0; scan < 50; ++scan) {
      map.integrate(see(scene, geometry, swaying_from(scan)));
      for (std::size_t bar = 0; bar < bars.size(); ++bar) {
        const Scene::Box& box = scene.boxes[first_bar + bar];
        const Eigen::Vector3f margin(0.005f, 0.005f, -0.02f);
        map.add_hit_voxels(box.low - margin, box.high + margin, bars[bar]);
      }
    }
    for (const VoxelSet& bar : bars) CHECK(map.share_of_layers(bar) == 1);
  }
}

TEST_CASE("a floor seen at two degrees stays occupied for five hundred scans" *
          doctest::test_suite("slow")) {
  // The rows of a long-range sensor that see the floor, and of its columns those that look ahead.
  const ScanGeometry geometry = geometry_of(staggered_sensor(12, 0.2, -5.6, 3.1, 512));
  VoxelConfig config;
  config.max_range_m = 20;
  for (const float height : {0.459f, 0.475f, 0.492f, 0.500f, 0.508f}) {
    CAPTURE(height);
    Scene scene;
    scene.boxes.push_back({{-60, -60, -1}, {60, 60, -height}});
    SceneMap map(geometry, config);
    VoxelSet grazed, all;
    for (int scan = 0; scan < 500; ++scan) {
      const auto motion = [scan](double seconds) {
        const double time = 0.1 * scan + seconds;
        Pose T(Eigen::AngleAxisd(0.003 * std::sin(1.3 * time), Eigen::Vector3d::UnitX()));
        T.translation().x() = 0.04 * time;
        return T;
      };
      Scan seen = see(scene, geometry, motion);
      for (int column = 0; column < 512; ++column)
        seen.column_valid[column] = std::abs(column - 256) < 48;
      map.integrate(seen);
      map.add_hit_voxels({11.5f, -5, -1}, {19, 5, 0}, grazed);
      map.add_hit_voxels({5, -2.2f, -1}, {19, 2.2f, 0}, all);
    }
    CHECK(grazed.size() > 4000);
    CHECK(map.share(grazed, VoxelState::kOccupied) > 0.98);
    CHECK(map.share(all, VoxelState::kOccupied) > 0.98);
  }
}

TEST_CASE("a floor stays occupied wherever in its voxels it lies" * doctest::test_suite("slow")) {
  const ScanGeometry geometry = geometry_of(long_range_sensor());
  for (int step = 0; step < 8; ++step) {
    const float height = 0.97f + 0.065f * static_cast<float>(step) / 8;
    CAPTURE(height);
    Scene scene;
    scene.add_room({-30, -12, -height}, {40, 12, 3});
    SceneMap map(geometry);
    VoxelSet floor;
    for (int scan = 0; scan < 120; ++scan) {
      const Motion motion = [scan](double seconds) {
        Pose T = upright_pose(0.04 * scan + 0.4 * seconds, 0, 0);
        T.rotate(Eigen::AngleAxisd(0.01 * std::sin(0.3 * scan), Eigen::Vector3d::UnitY()));
        return T;
      };
      Scan seen = see(scene, geometry, motion);
      for (int column = 0; column < 1024; ++column)
        seen.column_valid[column] = std::abs(column - 512) < 64;
      map.integrate(seen);
      map.add_hit_voxels({6, -5, -1.2f}, {20, 5, -0.9f}, floor);
    }
    CHECK(floor.size() > 3000);
    CHECK(map.share_standing(floor, {0, 0, -1}) > 0.98);
  }
}

TEST_CASE("a wall along the border of two layers of voxels is one layer thick") {
  VoxelConfig config;
  const auto voxel_m = static_cast<float>(config.voxel_size_m);
  Scene scene;
  scene.add_room({-3, -4, -1.2f}, {46 * voxel_m, 4, 1.6f});
  const ScanGeometry geometry = geometry_of(wide_sensor());
  SceneMap map(geometry, config);
  std::mt19937 rng(5);
  std::normal_distribution<double> noise_mm(0, 10);
  for (int scan = 0; scan < 40; ++scan) {
    Scan seen = see(scene, geometry, swaying_from(scan));
    for (std::uint32_t& range : seen.ranges_mm)
      range = static_cast<std::uint32_t>(std::lround(range + noise_mm(rng)));
    map.integrate(seen);
  }
  const auto layer = [&](int x) {
    const float low_x = static_cast<float>(x) * voxel_m;
    return map.voxels_in({low_x, -2, -0.7f}, {low_x + voxel_m, 2, 0.7f});
  };
  CHECK(map.share(layer(45), VoxelState::kFree) > 0.9);
  CHECK(map.share(layer(46), VoxelState::kOccupied) > 0.98);
}

TEST_CASE("the ground under the robot stays occupied" * doctest::test_suite("slow")) {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  for (const auto& [height, depth_m] :
       {std::pair{0.59f, 0.0}, std::pair{0.60f, 0.0}, std::pair{0.62f, 0.0}, std::pair{0.645f, 0.0},
        std::pair{0.59f, 0.025}, std::pair{0.645f, 0.025}}) {
    CAPTURE(height);
    CAPTURE(depth_m);
    VoxelConfig config;
    config.return_depth_m = depth_m;
    Scene scene;
    scene.add_room({-4, -4, -height}, {8, 4, 2});
    SceneMap map(geometry, config);
    VoxelSet ground;
    for (int scan = 0; scan < 40; ++scan) {
      map.integrate(see(scene, geometry, [scan](double seconds) {
        return upright_pose(0.1 * scan + seconds, 0, 0);
      }));
      map.add_hit_voxels({0, -1, -0.75f}, {4, 1, -0.5f}, ground);
    }
    CHECK(ground.size() > 1500);
    CHECK(map.share_standing(ground, {0, 0, depth_m > 0 ? -1 : 0}) > 0.99);
  }
}

TEST_CASE("a floor stays occupied when a third or half of the pixels is lost" *
          doctest::test_suite("slow")) {
  Scene scene;
  scene.add_room({-4, -4, -0.62f}, {12, 4, 2});
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    for (const double lost : {0.33, 0.5}) {
      CAPTURE(sensor.ring_radius_m);
      CAPTURE(lost);
      const ScanGeometry geometry = geometry_of(sensor);
      SceneMap map(geometry);
      VoxelSet ground;
      std::mt19937 rng(3);
      std::bernoulli_distribution is_lost(lost);
      for (int scan = 0; scan < 30; ++scan) {
        Scan seen = see(scene, geometry, [scan](double seconds) {
          return upright_pose(0.1 * scan + seconds, 0, 0);
        });
        for (std::uint32_t& range : seen.ranges_mm) range = is_lost(rng) ? 0 : range;
        map.integrate(seen);
        map.add_hit_voxels({0, -3, -0.75f}, {11, 3, -0.5f}, ground);
      }
      CHECK(ground.size() > 2000);
      CHECK(map.share(ground, VoxelState::kOccupied) > 0.98);
    }
  }
}

/// A person stands at some distance for two seconds and leaves.
struct Visit {
  SpinningSensor sensor;
  float distance;
  bool sways;
};

/// @return the share of the person's body that is occupied, that of all its voxels `scans` after it left, and the blocks
/// it left
std::tuple<double, double, int> watch(const Visit& visit, int scans) {
  Scene room;
  room.add_room({-3, -4, -1.2f}, {std::max(7.0f, visit.distance + 3), 4, 1.6f});
  Scene occupied_room = room;
  occupied_room.cylinders.push_back({{visit.distance, 0.4f}, 0.25f, -1.2f, 0.5f});
  const ScanGeometry geometry = geometry_of(visit.sensor);
  const auto motion = [&](int scan) {
    return visit.sways ? swaying_from(scan) : standing(swaying(0.3));
  };
  SceneMap map(geometry);
  VoxelSet person, body;  // all that is hit, and what more than one scan hits
  // Where all scans see it: not at the border of the field of view.
  const float reach_z = std::min(0.2f * visit.distance - 0.1f, 1.0f);
  const Eigen::Vector3f low(visit.distance - 0.26f, 0.14f, -reach_z);
  const Eigen::Vector3f high(visit.distance + 0.26f, 0.66f, std::min(reach_z, 0.55f));
  for (int scan = 0; scan < 20; ++scan) {
    map.integrate(see(occupied_room, geometry, motion(scan)));
    VoxelSet hit;
    map.add_hit_voxels(low, high, hit);
    hit.for_each([&](const VoxelCoord& v) { (person.contains(v) ? body : person).insert(v); });
  }
  const double before = map.share(body, VoxelState::kOccupied);
  for (int scan = 20; scan < 20 + scans; ++scan) map.integrate(see(room, geometry, motion(scan)));
  VoxelSet blocks;
  person.for_each([&](const VoxelCoord& v) {
    if (map.volume.view(map.store, parent_coord(v)).block != nullptr)
      blocks.insert(parent_coord(v));
  });
  return {before, map.share(person, VoxelState::kOccupied), static_cast<int>(blocks.size())};
}

TEST_CASE(
    "a person who leaves is free within a second of being seen through and its blocks return to "
    "the pool" *
    doctest::test_suite("slow")) {
  for (const Visit& visit :
       {Visit{long_range_sensor(), 3, true}, Visit{long_range_sensor(), 5, true},
        Visit{long_range_sensor(), 3, false}, Visit{long_range_sensor(), 5, false},
        Visit{long_range_sensor(), 8, false}, Visit{wide_sensor(), 1.5f, true},
        Visit{wide_sensor(), 1.5f, false}, Visit{wide_sensor(), 3, false}}) {
    CAPTURE(visit.sensor.ring_radius_m);
    CAPTURE(visit.distance);
    CAPTURE(visit.sways);
    const auto [before, after, blocks_left] = watch(visit, 10);
    CHECK(before > 0.99);
    CHECK(after < 0.005);
    CHECK(blocks_left == 0);
  }
}

TEST_CASE(
    "a person who leaves is free once beams have passed everywhere where rows are further apart "
    "than voxels" *
    doctest::test_suite("slow")) {
  for (const float distance : {3.0f, 5.0f}) {
    CAPTURE(distance);
    const auto [before, after, blocks_left] = watch({wide_sensor(), distance, true}, 40);
    CHECK(before > 0.98);
    CHECK(after == 0);
    CHECK(blocks_left == 0);
  }
}

TEST_CASE(
    "walls stay where they are at all azimuths while the sensor moves at 1 m/s and turns at 1 "
    "rad/s" *
    doctest::test_suite("slow")) {
  const Eigen::Vector3f low(-4.03f, -4.01f, -1.21f), high(4.02f, 4.04f, 1.63f);
  Scene scene;
  scene.add_room(low, high);
  // On a circle of a metre around the middle: the seam of the scans looks everywhere in turn.
  const auto on_circle = [](double time) {
    return upright_pose(std::sin(time), -std::cos(time), 0.02, time);
  };
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    CAPTURE(sensor.ring_radius_m);
    const ScanGeometry geometry = geometry_of(sensor);
    for (const auto& [num_scans, depth_m] :
         {std::pair{1, 0.0}, std::pair{63, 0.0}, std::pair{63, VoxelConfig{}.return_depth_m}}) {
      CAPTURE(num_scans);
      CAPTURE(depth_m);
      VoxelConfig config;
      config.return_depth_m = depth_m;
      SceneMap map(geometry, config);
      std::array<VoxelSet, 16> walls;  // by azimuth
      for (int scan = 0; scan < num_scans; ++scan) {
        map.integrate(
            see(scene, geometry, [&](double seconds) { return on_circle(0.1 * scan + seconds); }));
        VoxelSet hits;
        map.add_hit_voxels({-5, -5, -1.1f}, {5, 5, 1.5f}, hits);
        hits.for_each([&](const VoxelCoord& v) {
          const Eigen::Vector3f p = map.centre_of(v);
          const double turns = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi) + 0.5;
          walls[std::min(static_cast<int>(16 * turns), 15)].insert(v);
        });
      }
      for (int sector = 0; sector < 16; ++sector) {
        CAPTURE(sector);
        const double azimuth_rad = 2 * std::numbers::pi * ((sector + 0.5) / 16 - 0.5);
        const double x = std::cos(azimuth_rad), y = std::sin(azimuth_rad);
        const VoxelCoord outwards = std::abs(x) > std::abs(y) ? VoxelCoord(x > 0 ? 1 : -1, 0, 0)
                                                              : VoxelCoord(0, y > 0 ? 1 : -1, 0);
        CHECK(walls[sector].size() > 100);
        CHECK(map.share_standing(walls[sector], depth_m > 0 ? outwards : VoxelCoord(0, 0, 0)) >
              0.99);
      }
      int num_occupied = 0, num_stray = 0, num_carved = 0;
      map.volume.for_each_block(map.store, [&](const BlockCoord& block, const BlockView& view) {
        for (int i = 0; i < kBlockVoxels; ++i) {
          const Eigen::Vector3f p =
              map.centre_of(block * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6));
          const float inside_m = std::min((p - low).minCoeff(), (high - p).minCoeff());
          num_occupied += view.at(i) > 0;
          num_stray += view.at(i) > 0 && std::abs(inside_m) > 0.06f;
          num_carved += view.at(i) < 0 && inside_m < -0.033f;
        }
      });
      CHECK(num_occupied > 10'000);
      CHECK(num_stray == 0);
      CHECK(num_carved == 0);
      if (num_scans == 1) continue;
      const Eigen::Vector3f margin = Eigen::Vector3f::Constant(0.13f);
      const VoxelSet inside = map.voxels_in({low.x() + 0.13f, low.y() + 0.13f, -0.5f},
                                            {high.x() - 0.13f, high.y() - 0.13f, 0.5f});
      CHECK(map.share(inside, VoxelState::kFree) > 0.99);
      CHECK(map.share(map.voxels_in(low + margin, high - margin), VoxelState::kOccupied) == 0);
    }
  }
}

TEST_CASE("lost pixels between two others do not stop free space from being coarse") {
  Scene scene;
  scene.add_room({-8, -7, -1.2f}, {9, 8, 3});
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    CAPTURE(sensor.ring_radius_m);
    const ScanGeometry geometry = geometry_of(sensor);
    const Scan whole = see(scene, geometry, standing(swaying(0.3)));
    Scan holed = whole;
    for (std::size_t i = 0; i < holed.ranges_mm.size(); i += 41) holed.ranges_mm[i] = 0;
    SceneMap expected(geometry), map(geometry);
    const IntegrationResult of_whole = expected.integrate(whole);
    const IntegrationResult of_holed = map.integrate(holed);
    CHECK(static_cast<double>(of_holed.blocks_free) >
          0.99 * static_cast<double>(of_whole.blocks_free));
    CHECK(static_cast<double>(map.volume.num_blocks()) <
          1.02 * static_cast<double>(expected.volume.num_blocks()));
    const VoxelSet inside = map.voxels_in({-6, -6, -1}, {6, 6, 2});
    CHECK(map.share(inside, VoxelState::kFree) > expected.share(inside, VoxelState::kFree) - 0.005);
  }
}

}  // namespace
}  // namespace cloister
