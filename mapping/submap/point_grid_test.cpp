#include "mapping/submap/point_grid.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

namespace cloister {
namespace {

TEST_CASE("a cell keeps its first point") {
  PointGrid grid(0.25, 100);
  CHECK(grid.insert({0.1f, 0.1f, 0.1f}));
  CHECK_FALSE(grid.insert({0.2f, 0.2f, 0.2f}));
  CHECK(grid.insert({-0.1f, 0.1f, 0.1f}));
  CHECK(grid.size() == 2);
}

TEST_CASE("neighbours agree with a search of all points") {
  const unsigned seed = 3;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> coordinate(-4, 4);
  PointGrid grid(0.25, 1000);
  std::vector<Eigen::Vector3f> kept;
  for (int i = 0; i < 800; ++i) {
    const Eigen::Vector3f p(coordinate(rng), coordinate(rng), coordinate(rng));
    if (grid.insert(p)) kept.push_back(p);
  }
  const float radius = std::sqrt(3.0f) * 0.25f;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3f p(coordinate(rng), coordinate(rng), coordinate(rng));
    float nearest = 1e9f;
    for (const Eigen::Vector3f& q : kept) nearest = std::min(nearest, (p - q).norm());
    if (std::abs(nearest - radius) < 1e-5f) continue;
    CHECK(grid.has_neighbour(p) == (nearest < radius));
  }
}

TEST_CASE("a cleared grid is empty") {
  PointGrid grid(0.25, 10);
  CHECK(grid.insert({1, 1, 1}));
  grid.clear();
  CHECK(grid.size() == 0);
  CHECK_FALSE(grid.has_neighbour({1, 1, 1}));
  CHECK(grid.insert({1, 1, 1}));
}

TEST_CASE("a full grid declines") {
  PointGrid grid(0.25, 2);
  CHECK(grid.insert({0, 0, 0}));
  CHECK(grid.insert({1, 0, 0}));
  CHECK_FALSE(grid.insert({2, 0, 0}));
  CHECK(grid.is_full());
}

}  // namespace
}  // namespace cloister
