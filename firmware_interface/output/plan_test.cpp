#include "firmware_interface/output/plan.hpp"

#include <algorithm>
#include <random>
#include <set>

#include <doctest/doctest.h>

#include "firmware_interface/output/chart_svg.hpp"
#include "firmware_interface/output/plan_layer.hpp"
#include "firmware_interface/output/storeys.hpp"
#include "firmware_interface/output/submap_colour.hpp"
#include "firmware_interface/output/test_mission.hpp"

namespace cloister {
namespace {

using Path = std::vector<std::pair<SensorTime, Pose>>;

void walk(Path& path_M, const Eigen::Vector3d& to_M) {
  const Eigen::Vector3d from_M =
      path_M.empty() ? to_M : Eigen::Vector3d(path_M.back().second.translation());
  const int steps = static_cast<int>((to_M - from_M).norm() / 0.15) + 1;
  for (int k = 1; k <= steps; ++k) {
    const Eigen::Vector3d p_M = from_M + (to_M - from_M) * k / steps;
    path_M.emplace_back(SensorTime{}, make_pose(p_M, Eigen::Quaterniond::Identity()));
  }
}

TEST_CASE("a house of three storeys has three plans") {
  Path path_M;
  for (int storey = 0; storey < 3; ++storey) {
    const double z = 1.2 + 3.0 * storey;
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {8.0, 0.0}, {8.0, 6.0}, {0.0, 6.0}, {0.0, 0.0}})
      walk(path_M, {x, y, z});
    walk(path_M, {4, 0, z});
  }
  const Storeys found = find_storeys(path_M);
  REQUIRE(found.storeys.size() == 3);
  for (int i = 0; i < 3; ++i)
    CHECK(found.storeys[static_cast<std::size_t>(i)].sensor_z_m ==
          doctest::Approx(1.2 + 3.0 * i).epsilon(0.05));
  CHECK(found.of_pose.front() == 0);
  CHECK(found.of_pose.back() == 2);
  CHECK(std::is_sorted(found.of_pose.begin(), found.of_pose.end()));
}

TEST_CASE("a walk over terraces that do not lie above each other is one plan") {
  Path path_M;
  for (int terrace = 0; terrace < 4; ++terrace) {
    const double x = 40.0 * terrace;
    const double z = 4.0 * terrace;
    for (const auto& [dx, y] :
         {std::pair{0.0, 0.0}, {25.0, 0.0}, {25.0, 30.0}, {0.0, 30.0}, {0.0, 5.0}, {25.0, 5.0}})
      walk(path_M, {x + dx, y, z});
  }
  CHECK(find_storeys(path_M).storeys.size() == 1);
}

TEST_CASE("an even slope, a path that stands still, one pose and none are one storey each") {
  Path slope_M, still_M;
  walk(slope_M, {0, 0, 0});
  walk(slope_M, {200, 0, 30});
  walk(slope_M, {0, 3, 0});
  for (int k = 0; k < 100; ++k) still_M.push_back({SensorTime{}, Pose::Identity()});
  CHECK(find_storeys(slope_M).storeys.size() == 1);
  CHECK(find_storeys(still_M).storeys.size() == 1);
  CHECK(find_storeys({still_M.front()}).storeys.size() == 1);
  CHECK(find_storeys({}).storeys.size() == 1);
}

TEST_CASE("poses that are not finite, or absurdly far away, are survived") {
  Path path_M;
  walk(path_M, {0, 0, 0});
  walk(path_M, {5, 0, 0});
  path_M.emplace_back(SensorTime{},
                      make_pose({std::nan(""), 0, 0}, Eigen::Quaterniond::Identity()));
  path_M.emplace_back(SensorTime{}, make_pose({0, 0, 1e30}, Eigen::Quaterniond::Identity()));
  const Storeys found = find_storeys(path_M);
  CHECK(found.storeys.size() == 1);
  CHECK(found.of_pose.size() == path_M.size());
}

TEST_CASE("the plan of the test house shows each room on its own storey, in its own colour") {
  const MissionRecord record = make_test_mission();
  const Plan plan = make_plan(record);
  REQUIRE(plan.storeys.size() == 2);
  CHECK(plan.storeys[0].floor_z_m == doctest::Approx(0.0).epsilon(0.1));
  CHECK(plan.storeys[1].floor_z_m == doctest::Approx(2.9).epsilon(0.05));
  for (std::size_t s = 0; s < 2; ++s) {
    std::set<SubmapId> named;
    for (const auto& label : plan.storeys[s].labels) {
      named.insert(label.id);
      const SubmapRecord& room = record.submaps[static_cast<std::size_t>(label.id)];
      CHECK(label.at_M.x() > room.aabb_min_M.x() + 1.0);
      CHECK(label.at_M.x() < room.aabb_max_M.x() - 1.0);
    }
    CHECK(named == (s == 0 ? std::set<SubmapId>{0, 1, 2} : std::set<SubmapId>{3, 4, 5}));
  }
  CHECK(plan.storeys[0].start_M.has_value());
  CHECK(plan.storeys[0].end_M.has_value());
  CHECK_FALSE(plan.storeys[1].start_M.has_value());
}

TEST_CASE("walls show in the plan and ceilings do not") {
  const Plan plan = make_plan(make_test_mission());
  const PlanLayer& walls = plan.storeys[0].walls;
  const auto taken = static_cast<double>(
      std::count_if(walls.owner.begin(), walls.owner.end(), [](auto owner) { return owner >= 0; }));
  // The walls of the lower rooms are some 48 m long and take one or two cells across.
  CHECK(taken * walls.cell_m > 40.0);
  CHECK(taken * walls.cell_m < 120.0);
}

TEST_CASE("points none of which lie in the slice are drawn all the same") {
  MissionRecord record;
  SubmapRecord submap;
  submap.id = 4;
  for (int k = 0; k < 100; ++k)
    submap.surface_M.emplace_back(0.1f * static_cast<float>(k), 0.0f, 50.0f);
  record.submaps.push_back(submap);
  record.path_M.emplace_back(SensorTime{}, Pose::Identity());
  const Plan plan = make_plan(record);
  REQUIRE(plan.storeys.size() == 1);
  REQUIRE(plan.storeys[0].labels.size() == 1);
  CHECK(plan.storeys[0].labels[0].id == 4);
}

TEST_CASE("an empty mission has an empty plan") { CHECK(make_plan(MissionRecord{}).is_empty()); }

TEST_CASE("a cell goes to the submap with most points in it, the smaller index of equals") {
  const std::vector<LayerPoint> points = {{0.5f, 0.5f, 2}, {0.6f, 0.5f, 1}, {0.7f, 0.5f, 2},
                                          {1.5f, 0.5f, 3}, {1.6f, 0.5f, 0}, {9.0f, 0.5f, 5},
                                          {-1.0f, 0.5f, 5}};
  const PlanLayer layer = make_layer(points, {0, 0}, {2.5, 0.5}, 1.0);
  REQUIRE(layer.columns == 3);
  REQUIRE(layer.rows == 1);
  CHECK(layer.owner == std::vector<std::int32_t>{2, 0, -1});
}

TEST_CASE("merged rectangles cover every taken cell exactly once, by its owner") {
  const unsigned seed = 3;
  CAPTURE(seed);
  std::mt19937 random(seed);
  PlanLayer layer;
  layer.cell_m = 0.1;
  layer.columns = 37, layer.rows = 23;
  for (int i = 0; i < layer.columns * layer.rows; ++i)
    layer.owner.push_back(static_cast<std::int32_t>(random() % 4) - 1);
  std::vector<std::int32_t> painted(layer.owner.size(), -1);
  for (const PlanRectangle& r : merge_cells(layer)) {
    for (int row = r.row; row < r.row + r.height; ++row) {
      for (int column = r.column; column < r.column + r.width; ++column) {
        std::int32_t& cell = painted[static_cast<std::size_t>(row) * layer.columns + column];
        CHECK(cell == -1);
        cell = r.owner;
      }
    }
  }
  CHECK(painted == layer.owner);
}

TEST_CASE("smoothing takes specks away and keeps areas, free cells and ties") {
  PlanLayer layer{1.0, 12, 6, std::vector<std::int32_t>(72, -1)};
  const auto cell = [&layer](int column, int row) -> std::int32_t& {
    return layer.owner[static_cast<std::size_t>(row * 12 + column)];
  };
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 10; ++column) cell(column, row) = column < 5 ? 3 : 8;
  }
  const std::vector<std::int32_t> areas = layer.owner;
  cell(2, 3) = 8;
  cell(7, 1) = 0;
  smooth_owners(layer, 1);
  CHECK(layer.owner == areas);
}

TEST_CASE("a full layer merges into one rectangle") {
  PlanLayer layer{1.0, 40, 30, std::vector<std::int32_t>(1200, 7)};
  const auto rectangles = merge_cells(layer);
  REQUIRE(rectangles.size() == 1);
  CHECK(rectangles[0].width == 40);
  CHECK(rectangles[0].height == 30);
}

TEST_CASE("colours of the first hundred submaps differ, and neighbours differ clearly") {
  std::set<std::string> seen;
  for (SubmapId id = 0; id < 100; ++id) {
    const Rgb c = submap_colour(id);
    CHECK(submap_colour(id) == c);
    seen.insert(hex_colour(c));
    for (const SubmapId other : {id + 1, id + 2}) {
      const Rgb d = submap_colour(other);
      CAPTURE(id);
      CHECK(std::abs(c.r - d.r) + std::abs(c.g - d.g) + std::abs(c.b - d.b) > 60);
    }
  }
  CHECK(seen.size() == 100);
  CHECK(hex_colour({1, 160, 255}) == "#01a0ff");
}

TEST_CASE("a thinned series keeps its ends, its extremes and its order") {
  const unsigned seed = 8;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::vector<Sample> samples;
  for (int k = 0; k < 20'000; ++k)
    samples.push_back({0.1 * k, static_cast<double>(random() % 1'000'000)});
  const std::vector<Sample> thinned = thin(samples, 200);
  CHECK(thinned.size() <= 800);
  CHECK(thinned.front().t == samples.front().t);
  CHECK(thinned.back().t == samples.back().t);
  const auto by_value = [](const Sample& a, const Sample& b) { return a.value < b.value; };
  const auto by_time = [](const Sample& a, const Sample& b) { return a.t < b.t; };
  CHECK(std::max_element(thinned.begin(), thinned.end(), by_value)->value ==
        std::max_element(samples.begin(), samples.end(), by_value)->value);
  CHECK(std::min_element(thinned.begin(), thinned.end(), by_value)->value ==
        std::min_element(samples.begin(), samples.end(), by_value)->value);
  CHECK(std::is_sorted(thinned.begin(), thinned.end(), by_time));
}

}  // namespace
}  // namespace cloister
