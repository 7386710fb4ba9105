#include "mapping/mesh/marching_cubes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <doctest/doctest.h>

#include "mapping/mesh/cube_cases.hpp"

namespace cloister {
namespace {

constexpr double kVoxelSize = 0.1;

struct Fixture {
  Fixture() : store(4096, 256), pools(store) { pools.take_all(); }

  /// Fills the voxels of a box [low, high) with values of a function, then turns blocks into coarse
  /// nodes.
  void fill(const VoxelCoord& low, const VoxelCoord& high,
            const std::function<LogOdds(const VoxelCoord&)>& value_at) {
    std::set<std::tuple<int, int, int>> blocks;
    for (int z = low.z(); z < high.z(); ++z) {
      for (int y = low.y(); y < high.y(); ++y) {
        for (int x = low.x(); x < high.x(); ++x) {
          const VoxelCoord voxel(x, y, z);
          Chunk* chunk = nullptr;
          std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
          REQUIRE(place != nullptr);
          Block* block = volume.make_block(pools, *chunk, *place);
          REQUIRE(block != nullptr);
          block->voxels[index_in_block(voxel)] = value_at(voxel);
          blocks.emplace(x >> 3, y >> 3, z >> 3);
        }
      }
    }
    for (const auto& [x, y, z] : blocks) {
      Chunk* chunk = nullptr;
      std::uint32_t* place = volume.make_place(pools, {x, y, z}, &chunk);
      volume.settle_block(pools, *chunk, *place);
    }
  }

  void set_coarse(const BlockCoord& coord, LogOdds value, OctantMask known = kAllOctants) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, coord, &chunk);
    REQUIRE(place != nullptr);
    volume.set_coarse(pools, *chunk, *place, value, known);
  }

  [[nodiscard]] TriangleMesh mesh() const { return extract_mesh(store, volume, kVoxelSize); }

  VoxelStore store;
  VoxelPools pools;
  Volume volume;
};

/// How often each directed side occurs.
using Sides = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

Sides sides_of(const TriangleMesh& mesh) {
  Sides sides;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
  }
  return sides;
}

/// Sides without exactly one partner in the opposite direction.
std::vector<std::pair<std::uint32_t, std::uint32_t>> open_sides(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  const Sides sides = sides_of(mesh);
  for (const auto& [side, count] : sides) {
    CHECK(count == 1);
    if (!sides.contains({side.second, side.first})) open.push_back(side);
  }
  return open;
}

void check_vertices_are_used_and_distinct(const TriangleMesh& mesh) {
  std::set<std::uint32_t> used;
  for (const auto& t : mesh.triangles) used.insert(t.begin(), t.end());
  CHECK(used.size() == mesh.vertices_S.size());
  std::set<std::tuple<float, float, float>> positions;
  for (const auto& v : mesh.vertices_S) positions.emplace(v.x(), v.y(), v.z());
  CHECK(positions.size() == mesh.vertices_S.size());
}

long euler_characteristic(const TriangleMesh& mesh) {
  const long num_edges = static_cast<long>(sides_of(mesh).size()) / 2;
  return static_cast<long>(mesh.vertices_S.size()) - num_edges +
         static_cast<long>(mesh.triangles.size());
}

Eigen::Vector3d area_vector(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Eigen::Vector3d a = mesh.vertices_S[t[0]].cast<double>();
  const Eigen::Vector3d b = mesh.vertices_S[t[1]].cast<double>();
  const Eigen::Vector3d c = mesh.vertices_S[t[2]].cast<double>();
  return 0.5 * (b - a).cross(c - a);
}

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) sum += area_vector(mesh, i).norm();
  return sum;
}

/// Signed volume enclosed by a closed mesh; negative when its normals point inwards.
double enclosed_volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    sum += mesh.vertices_S[mesh.triangles[i][0]].cast<double>().dot(area_vector(mesh, i)) / 3.0;
  }
  return sum;
}

LogOdds clamp_log_odds(double value) {
  const double rounded = std::round(std::clamp(value, -40.0, 70.0));
  return static_cast<LogOdds>(rounded == 0 ? -1 : rounded);
}

TEST_CASE("an empty volume has an empty mesh") {
  Fixture f;
  const TriangleMesh mesh = f.mesh();
  CHECK(mesh.vertices_S.empty());
  CHECK(mesh.triangles.empty());
}

TEST_CASE("the triangles of a case use exactly the edges that change sign") {
  for (int occupied = 0; occupied < 256; ++occupied) {
    CAPTURE(occupied);
    std::set<int> used;
    for (int t = 0; t < kCubeCases[occupied].num_triangles; ++t) {
      for (const int edge : kCubeCases[occupied].triangles[t]) used.insert(edge);
    }
    std::set<int> crossed;
    for (int edge = 0; edge < 12; ++edge) {
      const int a = lower_corner(edge);
      const int b = a | 1 << edge / 4;
      if ((occupied >> a & 1) != (occupied >> b & 1)) crossed.insert(edge);
    }
    CHECK(used == crossed);
  }
}

TEST_CASE("a solid sphere becomes a closed surface of genus zero that faces outwards") {
  Fixture f;
  const Eigen::Vector3d centre(0.3, -0.6, 1.2);
  const double radius = 10.3;  // voxels
  f.fill({-16, -16, -16}, {16, 16, 16}, [&](const VoxelCoord& v) {
    const double distance = (v.cast<double>().array() + 0.5 - centre.array()).matrix().norm();
    return clamp_log_odds((radius - distance) * 20.0);
  });
  const TriangleMesh mesh = f.mesh();
  REQUIRE(mesh.triangles.size() > 1000);
  CHECK(open_sides(mesh).empty());
  CHECK(euler_characteristic(mesh) == 2);
  check_vertices_are_used_and_distinct(mesh);
  double worst = 0;
  for (const auto& vertex : mesh.vertices_S) {
    const double r = (vertex.cast<double>() / kVoxelSize - centre).norm();
    worst = std::max(worst, std::abs(r - radius));
  }
  CHECK(worst < 0.1);
  const double r_m = radius * kVoxelSize;
  CHECK(area(mesh) == doctest::Approx(4 * M_PI * r_m * r_m).epsilon(0.01));
  CHECK(enclosed_volume(mesh) == doctest::Approx(4.0 / 3.0 * M_PI * r_m * r_m * r_m).epsilon(0.01));
}

TEST_CASE("drawn deeper, a surface moves on to between the first two occupied voxels, whichever way it faces") {
  for (const bool is_free_below : {true, false}) {
    for (const double depth : {0.0, 0.5, 0.8}) {
      Fixture f;
      f.fill({0, 0, 0}, {8, 8, 8}, [&](const VoxelCoord& v) {
        return static_cast<LogOdds>((v.z() < 4) == is_free_below ? -10 : 30);
      });
      const TriangleMesh mesh = extract_mesh(f.store, f.volume, kVoxelSize, depth);
      const double before_occupied = 0.75 * (1 - depth) - 0.5 * depth;
      const double expected = (is_free_below ? 4.5 - before_occupied : 3.5 + before_occupied) * kVoxelSize;
      REQUIRE(!mesh.vertices_S.empty());
      for (const auto& vertex : mesh.vertices_S) CHECK(vertex.z() == doctest::Approx(expected).epsilon(1e-5));
    }
  }
}

TEST_CASE("drawn deeper, a sheet of one voxel is drawn around its middle") {
  Fixture f;
  f.fill({0, 0, 0}, {8, 8, 8}, [&](const VoxelCoord& v) { return static_cast<LogOdds>(v.z() == 4 ? 30 : -10); });
  const TriangleMesh mesh = extract_mesh(f.store, f.volume, kVoxelSize, 0.8);
  REQUIRE(!mesh.vertices_S.empty());
  for (const auto& vertex : mesh.vertices_S) CHECK(std::abs(vertex.z() / kVoxelSize - 4.5) == doctest::Approx(0.75 * 0.2).epsilon(1e-4));
}

TEST_CASE("a wall across block and chunk borders is one flat sheet without cracks") {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int wall : {-65, -64, -9, -8, -1, 0, 7, 63, 64}) {
      CAPTURE(axis);
      CAPTURE(wall);
      Fixture f;
      VoxelCoord low(-68, -4, -4), high(68, 6, 6);
      const int across = (axis + 1) % 3;
      low[across] = -68;
      high[across] = -60;
      low[axis] = wall - 4;
      high[axis] = wall + 6;
      f.fill(low, high,
             [&](const VoxelCoord& v) { return static_cast<LogOdds>(v[axis] < wall ? -10 : 30); });
      const TriangleMesh mesh = f.mesh();
      const VoxelCoord cubes = high - low - VoxelCoord::Ones();
      const int u = cubes[(axis + 1) % 3], v = cubes[(axis + 2) % 3];
      CHECK(mesh.triangles.size() == static_cast<std::size_t>(2 * u * v));
      CHECK(mesh.vertices_S.size() == static_cast<std::size_t>((u + 1) * (v + 1)));
      CHECK(open_sides(mesh).size() == static_cast<std::size_t>(2 * (u + v)));
      CHECK(area(mesh) == doctest::Approx(u * v * kVoxelSize * kVoxelSize));
      const double expected = (wall - 0.5 + 0.25) * kVoxelSize;
      for (const auto& vertex : mesh.vertices_S) {
        CHECK(vertex[axis] == doctest::Approx(expected).epsilon(1e-5));
      }
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        CHECK(area_vector(mesh, i)[axis] < 0);
      }
    }
  }
}

TEST_CASE("a diagonal wall one voxel thick has no holes") {
  Fixture f;
  f.fill({0, 0, 0}, {24, 24, 12},
         [](const VoxelCoord& v) { return static_cast<LogOdds>(v.x() == v.y() ? 30 : -30); });
  const TriangleMesh mesh = f.mesh();
  for (const auto& [from, to] : open_sides(mesh)) {
    for (const std::uint32_t vertex : {from, to}) {
      const Eigen::Vector3f p = mesh.vertices_S[vertex] / static_cast<float>(kVoxelSize);
      const bool is_at_border =
          (p.array() < 0.51f).any() || p.z() > 11.49f || p.x() > 23.49f || p.y() > 23.49f;
      CHECK(is_at_border);
    }
  }
}

TEST_CASE("coarse nodes meet each other and blocks without cracks") {
  Fixture f;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) f.set_coarse({x, y, z}, -8);
    }
  }
  f.set_coarse({0, 0, 0}, 20);
  const TriangleMesh mesh = f.mesh();
  CHECK(open_sides(mesh).empty());
  CHECK(euler_characteristic(mesh) == 2);
  CHECK(enclosed_volume(mesh) > 0.9 * std::pow(8 * kVoxelSize, 3));
  f.fill({7, 7, 7}, {9, 9, 9}, [](const VoxelCoord& v) {
    return static_cast<LogOdds>((v.x() + v.y() + v.z()) % 2 == 0 ? 20 : -3);
  });
  CHECK(open_sides(f.mesh()).empty());
}

TEST_CASE("partly known coarse nodes give the mesh of the same voxels one by one") {
  Fixture coarse, plain;
  for (int known = 1; known < 256; ++known) {
    // Its unknown octants border on the occupied voxels of the block beside it.
    const BlockCoord coord(2 * (known % 16), known / 16, 0);
    coarse.set_coarse(coord, -8, static_cast<OctantMask>(known));
    Chunk* chunk = nullptr;
    std::uint32_t* place = plain.volume.make_place(plain.pools, coord, &chunk);
    Block* block = plain.volume.make_block(plain.pools, *chunk, *place);
    for (int i = 0; i < kBlockVoxels; ++i) block->voxels[i] = known >> octant_of(i) & 1 ? -8 : kUnknownLogOdds;
    for (Fixture* f : {&coarse, &plain}) f->set_coarse(coord + BlockCoord(1, 0, 0), 20);
  }
  const TriangleMesh a = coarse.mesh(), b = plain.mesh();
  CHECK(a.vertices_S == b.vertices_S);
  CHECK(a.triangles == b.triangles);
  CHECK(a.triangles.size() > 10'000);
}

TEST_CASE("random known voxels inside free space give a closed oriented surface") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    for (const double share : {0.05, 0.3, 0.5, 0.8}) {
      CAPTURE(seed);
      CAPTURE(share);
      std::mt19937 rng(seed);
      std::bernoulli_distribution is_occupied(share);
      std::uniform_int_distribution<int> magnitude(1, 40);
      Fixture f;
      const VoxelCoord low(-70, -10, -5), high(-48, 12, 14);
      f.fill(low, high, [&](const VoxelCoord& v) {
        const bool is_rim =
            (v.array() == low.array()).any() || (v.array() == high.array() - 1).any();
        const int m = magnitude(rng);
        return static_cast<LogOdds>(!is_rim && is_occupied(rng) ? m : -m);
      });
      const TriangleMesh mesh = f.mesh();
      REQUIRE(!mesh.triangles.empty());
      CHECK(open_sides(mesh).empty());
      check_vertices_are_used_and_distinct(mesh);
      CHECK(enclosed_volume(mesh) > 0);
    }
  }
}

TEST_CASE("unknown corners leave out exactly the cubes they touch") {
  const unsigned seed = 11;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> value(-3, 3);
  Fixture f;
  f.fill({-12, -12, -12}, {12, 12, 12},
         [&](const VoxelCoord&) { return static_cast<LogOdds>(value(rng)); });
  const TriangleMesh mesh = f.mesh();
  std::size_t expected = 0;
  for (int z = -13; z < 13; ++z) {
    for (int y = -13; y < 13; ++y) {
      for (int x = -13; x < 13; ++x) {
        int occupied = 0;
        bool is_known = true;
        for (int c = 0; c < 8; ++c) {
          const LogOdds corner =
              f.volume.at(f.store, {x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)});
          is_known = is_known && corner != kUnknownLogOdds;
          occupied |= (corner > 0) << c;
        }
        if (is_known) expected += kCubeCases[occupied].num_triangles;
      }
    }
  }
  CHECK(expected > 0);
  CHECK(mesh.triangles.size() == expected);
  for (const auto& [side, count] : sides_of(mesh)) CHECK(count == 1);
}

TEST_CASE("the mesh does not depend on the order in which blocks were made") {
  Fixture forward, backward;
  const auto value = [](const VoxelCoord& v) {
    return static_cast<LogOdds>((v.x() * 7 + v.y() * 5 + v.z() * 3) % 4 < 2 ? -9 : 5);
  };
  for (int x = -3; x < 3; ++x) {
    forward.fill({x * 8, 0, 0}, {x * 8 + 8, 8, 8}, value);
    backward.fill({-x * 8 - 8, 0, 0}, {-x * 8, 8, 8}, value);
  }
  const TriangleMesh a = forward.mesh(), b = backward.mesh();
  CHECK(a.vertices_S == b.vertices_S);
  CHECK(a.triangles == b.triangles);
}

}  // namespace
}  // namespace cloister
