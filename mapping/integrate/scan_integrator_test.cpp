#include "mapping/integrate/scan_integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include "mapping/integrate/scene_for_tests.hpp"

namespace cloister {
namespace {

struct Fixture {
  explicit Fixture(std::size_t blocks = 20'000, std::size_t chunks = 2'000)
      : store(blocks, chunks), pools(store), integrator(config) {
    pools.take_all();
    config.return_depth_m = 0;
  }
  /// Integrates points seen from `origin` as one cloud.
  IntegrationResult integrate(const std::vector<Eigen::Vector3f>& points,
                              const Eigen::Vector3f& origin) {
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
    return volume.at(store,
                     {static_cast<int>(std::floor(v.x())), static_cast<int>(std::floor(v.y())),
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
  for (int i = 0; i < 300; ++i)
    points.emplace_back(coordinate(rng), coordinate(rng), coordinate(rng));
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

// ---- Range images ----

/// A furnished room with a doorway, seen by a sensor that stands at an angle.
Scene furnished_room() {
  Scene scene;
  scene.add_room({-5.03f, -6.02f, -1.17f}, {7.01f, 5.04f, 1.93f});
  scene.boxes.push_back({{3.0f, -6, -1.2f}, {3.1f, -1, 2}});
  scene.boxes.push_back({{3.0f, 0, -1.2f}, {3.1f, 5, 2}});
  scene.boxes.push_back({{-2, 1.5f, -1.2f}, {-1, 2.3f, -0.4f}});
  scene.cylinders.push_back({{1.5f, -1.5f}, 0.25f, -1.2f, 0.6f});
  scene.cylinders.push_back({{0.8f, 2.4f}, 0.03f, -1.2f, 2});
  return scene;
}
Pose tilted_pose() {
  Pose T(Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, -0.08, 0.9).normalized()));
  T.translation() = Eigen::Vector3d(0.13, -0.21, 0.07);
  return T;
}
/// Walks at 1 m/s and turns at 1 rad/s.
Motion walking_from(int scan) {
  return [scan](double seconds) {
    const double time = 0.1 * scan + seconds;
    return upright_pose(std::sin(time), -std::cos(time), 0.02 * std::sin(3 * time), time) *
           tilted_pose();
  };
}

/// All that is known, in an order that depends on content only.
std::vector<std::tuple<int, int, int, std::vector<LogOdds>>> content_of(const SceneMap& map) {
  std::vector<std::tuple<int, int, int, std::vector<LogOdds>>> content;
  map.volume.for_each_block(map.store, [&](const BlockCoord& block, const BlockView& view) {
    std::vector<LogOdds> voxels(kBlockVoxels);
    for (int i = 0; i < kBlockVoxels; ++i) voxels[i] = view.at(i);
    content.emplace_back(block.x(), block.y(), block.z(), std::move(voxels));
  });
  std::sort(content.begin(), content.end());
  return content;
}

TEST_CASE("every instruction set of this machine gives the same map, bit by bit") {
  const Scene scene = furnished_room();
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    std::vector<Scan> scans;
    for (int scan = 0; scan < 3; ++scan) scans.push_back(see(scene, geometry, walking_from(scan)));
    for (int scan = 0; scan < 2; ++scan)
      scans.push_back(see(scene, geometry, standing(tilted_pose())));
    const auto integrate_all = [&] {
      SceneMap map(geometry);
      for (const Scan& scan : scans) map.integrate(scan);
      return content_of(map);
    };
    const auto expected = integrate_all();
    CHECK(expected.size() > 1000);
    int num_targets = 0;
    const std::int64_t supported = hwy::SupportedTargets();
    for (std::int64_t rest = supported; rest != 0; rest &= rest - 1) {
      const std::int64_t target = rest & -rest;
      CAPTURE(hwy::TargetName(target));
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      CHECK(integrate_all() == expected);
      ++num_targets;
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    CHECK(hwy::SupportedTargets() == supported);
    CHECK(num_targets > 0);
  }
}

/// As many threads as asked for, begun anew for each scan.
class TestThreads : public ScanWorkers {
 public:
  explicit TestThreads(int num) : num_(num) {}
  [[nodiscard]] int num() const override { return num_; }
  void run(void (*task)(void* context, int worker), void* context) override {
    ++num_runs;
    std::vector<std::thread> threads;
    for (int worker = 1; worker < num_; ++worker) threads.emplace_back(task, context, worker);
    task(context, 0);
    for (std::thread& thread : threads) thread.join();
  }
  int num_runs = 0;

 private:
  int num_;
};

TEST_CASE("a scan that several threads share gives the same map, and the same numbers") {
  const Scene scene = furnished_room();
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    const ScanGeometry geometry = geometry_of(sensor);
    TestThreads three(3);
    SceneMap alone(geometry);
    SceneMap shared(geometry, {}, 60'000, 4'000, &three);
    for (int i = 0; i < 4; ++i) {
      const Scan scan = see(scene, geometry, walking_from(i));
      const IntegrationResult a = alone.integrate(scan);
      const IntegrationResult b = shared.integrate(scan);
      CHECK(a.blocks_free == b.blocks_free);
      CHECK(a.blocks_mixed == b.blocks_mixed);
      CHECK(b.voxels_declined == 0);
    }
    CHECK(three.num_runs >= 4);
    CHECK(content_of(shared) == content_of(alone));
    CHECK(shared.volume.bytes() == alone.volume.bytes());
  }
}

TEST_CASE("shared, more decisions than a worker has room for take another round") {
  // Seen from a hall's middle, more blocks are free than one worker can note at once.
  Scene hall;
  hall.add_room({-28, -28, -2}, {28, 28, 12});
  const ScanGeometry geometry = geometry_of(wide_sensor());
  const Scan scan = see(hall, geometry, standing(tilted_pose()));
  TestThreads one_more(2);
  SceneMap alone(geometry, {}, 60'000, 8'000);
  SceneMap shared(geometry, {}, 60'000, 8'000, &one_more);
  alone.integrate(scan);
  shared.integrate(scan);
  CHECK(one_more.num_runs > 1);
  CHECK(content_of(shared) == content_of(alone));
}

TEST_CASE("a scan without any return changes nothing") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  SceneMap map(geometry);
  Scan scan = see(furnished_room(), geometry, walking_from(0));
  map.integrate(scan);
  const auto before = content_of(map);
  const std::size_t bytes = map.volume.bytes();
  scan.ranges_mm.assign(scan.ranges_mm.size(), 0);
  for (int i = 0; i < 2; ++i) {
    const IntegrationResult result = map.integrate(scan);
    CHECK(result.blocks_hit == 0);
    CHECK(result.blocks_free == 0);
    CHECK(result.voxels_declined == 0);
  }
  CHECK(content_of(map) == before);
  CHECK(map.volume.bytes() == bytes);
}

TEST_CASE("full pools decline an image's updates, count them, and keep what is there") {
  const ScanGeometry geometry = geometry_of(wide_sensor());
  const Scan scan = see(furnished_room(), geometry, standing(tilted_pose()));
  SceneMap roomy(geometry);
  CHECK(roomy.integrate(scan).voxels_declined == 0);
  for (const auto& [blocks, chunks] :
       {std::pair<std::size_t, std::size_t>{100, 2000}, {20'000, 5}, {0, 0}}) {
    CAPTURE(blocks);
    CAPTURE(chunks);
    SceneMap map(geometry, {}, blocks, chunks);
    CHECK(map.integrate(scan).voxels_declined > 10'000);
    CHECK(map.volume.num_blocks() <= blocks);
    CHECK(map.volume.num_chunks() <= chunks);
    CHECK(map.volume.num_blocks() + map.pools.blocks.num_free() == blocks);
    CHECK(map.volume.num_chunks() + map.pools.chunks.num_free() == chunks);
    // What is there is what a roomy map has there.
    int num_strange = 0;
    map.volume.for_each_block(map.store, [&](const BlockCoord& block, const BlockView& view) {
      const BlockView other = roomy.volume.view(roomy.store, block);
      for (int i = 0; i < kBlockVoxels; ++i) {
        num_strange +=
            view.at(i) != kUnknownLogOdds && state_of(view.at(i)) != state_of(other.at(i));
      }
    });
    CHECK(num_strange == 0);
  }
}

TEST_CASE("hits outweigh what an image's beams cross in the same scan") {
  const ScanGeometry geometry = geometry_of(long_range_sensor());
  SceneMap map(geometry);
  map.integrate(see(furnished_room(), geometry, walking_from(0)));
  for (std::size_t i = 0; i < map.beams.num_returns(); ++i)
    REQUIRE(map.at(map.beams.return_S(i)) == 17);
}

/// What the documented rule makes of a voxel in a fresh map, by itself and in double precision. Where it is a matter of
/// some hundredths of a pixel or millimetres, it does not say.
class Rule {
 public:
  explicit Rule(const SceneMap& map)
      : image_(map.beams.image()),
        projection_(*image_.projection),
        voxel_m_(map.config.voxel_size_m) {
    for (std::size_t i = 0; i < map.beams.num_returns(); ++i) {
      const VoxelCoord voxel = map.voxel_of(map.beams.return_S(i));
      hit_.insert(voxel);
      hit_blocks_.insert(parent_coord(voxel));
    }
  }

  /// States of a block's voxels; nothing where it is uncertain.
  [[nodiscard]] std::vector<std::optional<VoxelState>> states(const BlockCoord& block) const {
    const bool has_hits = hit_blocks_.contains(block);
    const Eigen::Vector3d corner = block.cast<double>() * kBlockEdge;
    std::array<bool, kBlockVoxels> is_surely_free{}, may_be_free{};
    int least_free[8] = {}, most_free[8] = {};
    for (int i = 0; i < kBlockVoxels; ++i) {
      std::tie(is_surely_free[i], may_be_free[i]) =
          sees_through(corner + Eigen::Vector3d((i & 7) + 0.5, (i >> 3 & 7) + 0.5, (i >> 6) + 0.5));
      least_free[octant_of(i)] += is_surely_free[i];
      most_free[octant_of(i)] += may_be_free[i];
    }
    const double distance = (corner + Eigen::Vector3d::Constant(kOctantEdge) -
                             image_.poses.front().t_S.cast<double>() / voxel_m_)
                                .norm();
    std::array<std::pair<bool, bool>, 8> middles;
    for (int i = 0; i < 8; ++i) {
      middles[i] = sees_through(corner + Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2) * kOctantEdge +
                                Eigen::Vector3d::Constant(0.5 * kOctantEdge));
      // Close to the sensor, middles are not asked for.
      middles[i].first |= distance < 38;
      middles[i].second |= distance < 42;
    }
    std::vector<std::optional<VoxelState>> states(kBlockVoxels);
    // Without returns, an octant is free as a whole or not at all: when its middle and three quarters of its voxels are.
    constexpr int kEnough = kOctantVoxels * 3 / 4;
    for (int i = 0; i < kBlockVoxels; ++i) {
      const int octant = octant_of(i);
      const auto [middle_is_free, middle_may_be_free] = middles[octant];
      if (has_hits ? is_surely_free[i] : middle_is_free && least_free[octant] >= kEnough)
        states[i] = VoxelState::kFree;
      if (has_hits ? !may_be_free[i] : !middle_may_be_free || most_free[octant] < kEnough) {
        states[i] = VoxelState::kUnknown;
      }
      const VoxelCoord voxel = block * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
      if (has_hits && hit_.contains(voxel)) states[i] = VoxelState::kOccupied;
    }
    return states;
  }

 private:
  struct Offset {
    double rows, columns, distance_m, reach;
  };
  static constexpr Offset kOffsets[] = {{0, 0, 0, 1},
                                        {0.04, 0.05, 0.004, 1},
                                        {-0.04, 0.05, 0.004, 1},
                                        {0.04, -0.05, -0.004, 1},
                                        {-0.04, -0.05, -0.004, 1},
                                        {0, 0, 0, 0.93},
                                        {0, 0, 0, 1.07}};

  /// Is a place, in voxels, free for sure, and may it be?
  [[nodiscard]] std::pair<bool, bool> sees_through(const Eigen::Vector3d& place) const {
    bool always = true, ever = false;
    for (const Offset& offset : kOffsets) {
      const bool is_free_there = is_free(place * voxel_m_, offset);
      always &= is_free_there;
      ever |= is_free_there;
    }
    return {always, ever};
  }

  [[nodiscard]] bool is_free(const Eigen::Vector3d& p_S, const Offset& offset) const {
    const RangeImage::ColumnPose& pose = image_.poses.front();
    Eigen::Matrix3d R_L_S;
    for (int i = 0; i < 9; ++i) R_L_S(i / 3, i % 3) = pose.R_L_S[i / 3][i % 3];
    const Eigen::Vector3d p_L = R_L_S * (p_S - pose.t_S.cast<double>());
    const double axis = std::hypot(p_L.x(), p_L.y()), z = p_L.z() - projection_.ring_height_m;
    const double distance = std::hypot(axis - projection_.ring_radius_m, z) + offset.distance_m;
    const double columns = projection_.num_columns;
    double column =
        (std::atan2(p_L.y(), p_L.x()) - projection_.azimuth0_rad) * projection_.columns_per_rad +
        offset.columns;
    column -= columns * std::floor(column / columns);
    const double step = (1 + z / distance) / 2 * SphericalProjection::kSineSteps;
    const int at = std::clamp(static_cast<int>(step), 0, SphericalProjection::kSineSteps);
    const double lower = projection_.row_of_sine[at],
                 rise = projection_.row_of_sine[at + 1] - lower;
    const double row = lower + rise * (step - at) + offset.rows;
    // As far as a voxel reaches along the directions of rising azimuth and elevation.
    const double c = p_L.x() / axis, s = p_L.y() / axis,
                 cos_up = (axis - projection_.ring_radius_m) / distance;
    const Eigen::Vector3d around_S = R_L_S.transpose() * Eigen::Vector3d(-s, c, 0);
    const Eigen::Vector3d up_S =
        R_L_S.transpose() * Eigen::Vector3d(-c * z / distance, -s * z / distance, cos_up);
    const double half_voxel_m = 0.505 * offset.reach * voxel_m_;
    const double column_reach =
        half_voxel_m * around_S.lpNorm<1>() / axis * std::abs(projection_.columns_per_rad);
    const double rows_per_rad =
        std::abs(rise) * SphericalProjection::kSineSteps / 2 * std::abs(cos_up);
    const double row_reach = half_voxel_m * up_S.lpNorm<1>() / distance * rows_per_rad;
    const int last_row = projection_.num_rows() - 1;
    // Voxels are less than a fifth wider than pixels: what do all four beams around prove?
    if (column_reach < 0.6 || row_reach < 0.6) {
      const int row0 = static_cast<int>(std::floor(row)),
                column0 = static_cast<int>(std::floor(column));
      return row0 >= 0 && row0 < last_row && pixel(image_.gap_free_m, row0, column0) >= distance;
    }
    const double beam_row = std::clamp(std::round(row), 0.0, static_cast<double>(last_row));
    const double beam_column = std::round(column);
    return std::abs(row - beam_row) <= row_reach &&
           std::abs(column - beam_column) <= column_reach &&
           pixel(image_.free_m, static_cast<int>(beam_row), static_cast<int>(beam_column)) >=
               distance;
  }
  [[nodiscard]] float pixel(const std::vector<float>& image, int row, int column) const {
    return image[static_cast<std::size_t>(row) * image_.stride +
                 (column & (projection_.num_columns - 1))];
  }

  const RangeImage& image_;
  const SphericalProjection& projection_;
  double voxel_m_;
  VoxelSet hit_, hit_blocks_;
};

TEST_CASE("a scan's map agrees with the beam model evaluated voxel by voxel") {
  for (const SpinningSensor& sensor : {wide_sensor(), long_range_sensor()}) {
    CAPTURE(sensor.ring_radius_m);
    const ScanGeometry geometry = geometry_of(sensor);
    SceneMap map(geometry);
    map.integrate(see(furnished_room(), geometry, standing(tilted_pose())));
    const Rule rule(map);
    std::int64_t num_known = 0, num_uncertain = 0, num_too_free = 0, num_too_unknown = 0,
                 num_wrong_hits = 0;
    for (int z = -4; z < 5; ++z) {
      for (int y = -14; y < 12; ++y) {
        for (int x = -12; x < 16; ++x) {
          if ((x + y + z) % 3 != 0) continue;  // a sample is enough
          const BlockView view = map.volume.view(map.store, {x, y, z});
          const std::vector<std::optional<VoxelState>> expected = rule.states({x, y, z});
          for (int i = 0; i < kBlockVoxels; ++i) {
            const VoxelState state = state_of(view.at(i));
            num_known += state != VoxelState::kUnknown;
            num_uncertain += !expected[i];
            if (!expected[i]) continue;
            num_wrong_hits +=
                (state == VoxelState::kOccupied) != (expected[i] == VoxelState::kOccupied);
            num_too_free += state == VoxelState::kFree && expected[i] == VoxelState::kUnknown;
            num_too_unknown += state == VoxelState::kUnknown && expected[i] == VoxelState::kFree;
          }
        }
      }
    }
    CAPTURE(num_too_free);
    CAPTURE(num_too_unknown);
    CHECK(num_known > 150'000);
    CHECK(static_cast<double>(num_uncertain) < 0.05 * static_cast<double>(num_known));
    CHECK(num_wrong_hits == 0);
    CHECK(static_cast<double>(num_too_free + num_too_unknown) <
          0.001 * static_cast<double>(num_known));
  }
}

}  // namespace
}  // namespace cloister
