#include "mapping/mesh/drawn_surfaces.hpp"

#include <cmath>
#include <functional>
#include <set>

#include <doctest/doctest.h>

#include "mapping/mesh/marching_cubes.hpp"

namespace cloister {
namespace {

constexpr double kVoxelM = 0.1;

/// Two submaps of one pool, filled from what is true in M: distances to the nearest surface, negative behind it.
struct TwoSubmaps {
  TwoSubmaps() : store(4096, 256), pools(store) { pools.take_all(); }

  /// Fills 40x40x20 voxels around S's origin; what the function calls unknown (NaN) stays so.
  void fill(Submap& submap, const Pose& T_M_S,
            const std::function<double(const Eigen::Vector3d&)>& distance_m) {
    submap.T_M_S = T_M_S;
    for (int z = -10; z < 10; ++z) {
      for (int y = -20; y < 20; ++y) {
        for (int x = -20; x < 20; ++x) {
          const VoxelCoord voxel(x, y, z);
          const Eigen::Vector3d p_S = (voxel.cast<double>().array() + 0.5) * kVoxelM;
          const double d_m = distance_m(T_M_S * p_S);
          if (std::isnan(d_m)) continue;
          Chunk* chunk = nullptr;
          std::uint32_t* place = submap.volume.make_place(pools, parent_coord(voxel), &chunk);
          REQUIRE(place != nullptr);
          Block* block = submap.volume.make_block(pools, *chunk, *place);
          REQUIRE(block != nullptr);
          block->voxels[index_in_block(voxel)] = d_m > 0 ? LogOdds{-20} : LogOdds{30};
        }
      }
    }
  }

  [[nodiscard]] TriangleMesh mesh_of(const Submap& submap) const {
    return extract_mesh(store, submap.volume, kVoxelM);
  }

  /// What is left of b's mesh once a's has been drawn.
  [[nodiscard]] TriangleMesh rest_of_b() const {
    DrawnSurfaces drawn(store, kVoxelM);
    drawn.add(a);
    TriangleMesh mesh = mesh_of(b);
    drawn.leave_out(b, mesh);
    return mesh;
  }

  VoxelStore store;
  VoxelPools pools;
  Submap a, b;
};

/// A floor at height 0.
double floor_m(const Eigen::Vector3d& p_M) { return p_M.z(); }

Pose turned(double yaw_rad, double z_m) {
  return make_pose({0.03, 0.04, z_m},
                   Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())));
}

void check_vertices_are_used(const TriangleMesh& mesh) {
  std::set<std::uint32_t> used;
  for (const auto& triangle : mesh.triangles) used.insert(triangle.begin(), triangle.end());
  CHECK(used.size() == mesh.vertices_S.size());
  CHECK((used.empty() || *used.rbegin() + 1 == mesh.vertices_S.size()));
}

TEST_CASE("a floor that two turned submaps see some voxels apart is drawn once") {
  for (const double apart_m : {0.2, 0.4}) {
    CAPTURE(apart_m);
    TwoSubmaps map;
    map.fill(map.a, Pose::Identity(), floor_m);
    map.fill(map.b, turned(0.3, 0),
             [&](const Eigen::Vector3d& p_M) { return floor_m(p_M) - apart_m; });
    REQUIRE(map.mesh_of(map.b).triangles.size() > 2'000);
    const TriangleMesh rest = map.rest_of_b();
    // Where b reaches beyond a, it goes on.
    for (const auto& triangle : rest.triangles) {
      int num_outside = 0;
      for (const std::uint32_t vertex : triangle) {
        const Eigen::Vector3d p_M = map.b.T_M_S * rest.vertices_S[vertex].cast<double>();
        num_outside += p_M.head<2>().cwiseAbs().maxCoeff() > 1.9;
      }
      REQUIRE(num_outside > 0);
    }
    CHECK(rest.triangles.size() > 100);
    check_vertices_are_used(rest);
  }
}

TEST_CASE("a floor six voxels above another one is drawn as well") {
  TwoSubmaps map;
  map.fill(map.a, Pose::Identity(), floor_m);
  map.fill(map.b, turned(0.3, 0), [](const Eigen::Vector3d& p_M) { return floor_m(p_M) - 0.6; });
  CHECK(map.rest_of_b().triangles == map.mesh_of(map.b).triangles);
}

TEST_CASE("both sides of a thin slab are drawn, each by the submap that sees it") {
  TwoSubmaps map;
  map.fill(map.a, Pose::Identity(), floor_m);
  map.fill(map.b, turned(0.3, 0), [](const Eigen::Vector3d& p_M) { return -floor_m(p_M) - 0.1; });
  CHECK(map.rest_of_b().triangles == map.mesh_of(map.b).triangles);
}

TEST_CASE("a surface is drawn where the submap drawn before knows nothing of it") {
  TwoSubmaps map;
  map.fill(map.a, Pose::Identity(),
           [](const Eigen::Vector3d& p_M) { return p_M.x() < 0 ? std::nan("") : floor_m(p_M); });
  map.fill(map.b, Pose::Identity(), floor_m);
  const TriangleMesh rest = map.rest_of_b();
  // A cube with an unknown corner has no triangle: b closes the seam.
  for (const Eigen::Vector3f& vertex : rest.vertices_S) CHECK(vertex.x() < 0.16f);
  CHECK(rest.triangles.size() > map.mesh_of(map.b).triangles.size() / 2 - 50);
  check_vertices_are_used(rest);
}

TEST_CASE("submaps that know nothing draw nothing and leave nothing out") {
  TwoSubmaps map;
  map.fill(map.b, Pose::Identity(), floor_m);
  CHECK(map.rest_of_b().triangles == map.mesh_of(map.b).triangles);
}

}  // namespace
}  // namespace cloister
