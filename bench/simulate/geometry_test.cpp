#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <Eigen/Geometry>
#include <doctest/doctest.h>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/building.hpp"
#include "bench/simulate/ply_file.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/ray_scene.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

double area_of(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const Eigen::Vector3f e1 = mesh.corner(k, 1) - mesh.corner(k, 0);
    const Eigen::Vector3f e2 = mesh.corner(k, 2) - mesh.corner(k, 0);
    area += 0.5 * static_cast<double>(e1.cross(e2).norm());
  }
  return area;
}

BoxSolid box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return BoxSolid::from_corners_m({x0, y0, z0}, {x1, y1, z1}, 0.5F);
}

fs::path scratch_file(const std::string& name, const std::string& text) {
  const fs::path path =
      fs::temp_directory_path() / ("cloister-geometry-test-" + std::to_string(getpid()) + name);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

TEST_CASE("the surface of one block is its six faces") {
  const std::vector<BoxSolid> solids = {box(0, 0, 0, 1, 2, 3)};
  const TriangleMesh mesh = union_surface(solids);
  CHECK(mesh.triangles.size() == 12);
  CHECK(area_of(mesh) == doctest::Approx(22.0));
}

TEST_CASE("faces that blocks share are no part of their surface") {
  SUBCASE("side by side") {
    CHECK(area_of(union_surface(std::vector{box(0, 0, 0, 1, 1, 1), box(1, 0, 0, 2, 1, 1)})) ==
          doctest::Approx(10.0));
  }
  SUBCASE("small on large") {
    CHECK(area_of(union_surface(std::vector{box(0, 0, 0, 3, 3, 1), box(1, 1, 1, 2, 2, 2)})) ==
          doctest::Approx(34.0));
  }
  SUBCASE("one inside the other, with a common face") {
    CHECK(area_of(union_surface(
              std::vector{box(0, 0, 0, 1, 1, 1), box(0, 0.25, 0.25, 0.5, 0.75, 0.75)})) ==
          doctest::Approx(6.0));
  }
  SUBCASE("the same twice") {
    CHECK(area_of(union_surface(std::vector{box(0, 0, 0, 1, 1, 1), box(0, 0, 0, 1, 1, 1)})) ==
          doctest::Approx(6.0));
  }
}

TEST_CASE("a wall with a door and a window keeps exactly the material between them") {
  std::vector<BoxSolid> solids;
  append_wall({true, 0.0, 0.0, 5.0, 0.0, 2.5, 0.1, {{3.5, 1.0, 1.0, 2.0}, {1.5, 0.9, 0.0, 2.0}}},
              0.5F, &solids);
  double volume = 0.0;
  for (const BoxSolid& s : solids) volume += (s.max_m() - s.min_m()).prod();
  CHECK(volume == doctest::Approx(0.1 * (5.0 * 2.5 - 0.9 * 2.0 - 1.0 * 1.0)));
  const auto is_solid = [&](double x, double z) {
    for (const BoxSolid& s : solids) {
      if (s.contains({x, 0.0, z})) return true;
    }
    return false;
  };
  CHECK_FALSE(is_solid(1.5, 1.0));
  CHECK(is_solid(1.5, 2.2));
  CHECK(is_solid(3.5, 0.5));
  CHECK_FALSE(is_solid(3.5, 1.5));
}

TEST_CASE("inside and outside agree between crossings of the surface and the blocks themselves") {
  constexpr std::uint64_t kSeed = 3;
  CAPTURE(kSeed);
  RandomStream random(kSeed, 1);
  std::vector<BoxSolid> solids;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d a(random.uniform(0, 4), random.uniform(0, 4), random.uniform(0, 4));
    solids.push_back(BoxSolid::from_corners_m(
        a,
        a + Eigen::Vector3d(random.uniform(0.1, 1.5), random.uniform(0.1, 1.5),
                            random.uniform(0.1, 1.5)),
        0.5F));
  }
  const TriangleMesh mesh = union_surface(solids);
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  int inside = 0;
  for (int k = 0; k < 5000; ++k) {
    const Eigen::Vector3d p(random.uniform(-1, 6), random.uniform(-1, 6), random.uniform(-1, 6));
    if (scene->distance(p.cast<float>(), 1.0F) < 1e-4F) continue;
    bool expected = false;
    for (const BoxSolid& s : solids) expected = expected || s.contains(p);
    inside += expected ? 1 : 0;
    CHECK(scene->is_inside(p.cast<float>()) == expected);
  }
  CHECK(inside > 200);
}

TEST_CASE("distances to a cube are those of the closed form") {
  const TriangleMesh mesh = union_surface(std::vector{box(-1, -1, -1, 1, 1, 1)});
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  RandomStream random(5, 1);
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d p(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3));
    const Eigen::Vector3d beyond = p.cwiseAbs() - Eigen::Vector3d::Ones();
    const double expected =
        beyond.maxCoeff() > 0.0 ? beyond.cwiseMax(0.0).norm() : -beyond.maxCoeff();
    CHECK(scene->distance(p.cast<float>(), 10.0F) == doctest::Approx(expected).epsilon(1e-5));
  }
  CHECK(scene->distance({5.0F, 0.0F, 0.0F}, 0.5F) == 0.5F);
}

TEST_CASE("rays inside a box room end on its walls") {
  const TriangleMesh mesh = union_surface(
      std::vector{box(-1, -1, -1, 7, 6, 0), box(-1, -1, 3, 7, 6, 4), box(-1, -1, 0, 0, 6, 3),
                  box(6, -1, 0, 7, 6, 3), box(0, -1, 0, 6, 0, 3), box(0, 5, 0, 6, 6, 3)});
  const auto scene = RayScene::build(mesh);
  REQUIRE(scene);
  const Eigen::Vector3f origin(1.5F, 2.0F, 1.2F);
  RandomStream random(9, 1);
  std::vector<Eigen::Vector3f> directions;
  for (int k = 0; k < 100; ++k) {  // not a multiple of the packet's width
    directions.push_back(Eigen::Vector3d(random.normal(), random.normal(), random.normal())
                             .normalized()
                             .cast<float>());
  }
  std::vector<RayHit> hits(directions.size());
  scene->cast(origin, directions, 50.0F, hits);
  for (std::size_t k = 0; k < hits.size(); ++k) {
    float expected = 1e9F;
    int wall = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float wall_at = directions[k][axis] > 0.0F ? Eigen::Vector3f(6, 5, 3)[axis] : 0.0F;
      const float reach = (wall_at - origin[axis]) / directions[k][axis];
      if (reach < expected) {
        expected = reach;
        wall = axis;
      }
    }
    REQUIRE(hits[k].triangle != RayHit::kNone);
    CHECK(hits[k].distance_m == doctest::Approx(expected).epsilon(1e-5));
    CHECK(hits[k].cos_incidence == doctest::Approx(std::abs(directions[k][wall])).epsilon(1e-4));
  }
  scene->cast(origin, directions, 0.5F, hits);
  for (const RayHit& hit : hits) CHECK(hit.triangle == RayHit::kNone);
  CHECK(scene->line_of_sight(origin, {5.0F, 4.0F, 2.0F}));
  CHECK_FALSE(scene->line_of_sight(origin, {9.0F, 4.0F, 2.0F}));
}

TEST_CASE("a mesh survives being written and read") {
  const TriangleMesh mesh =
      union_surface(std::vector{box(0, 0, 0, 1, 2, 3), box(0.5, 0.5, 2, 4, 1, 3.5)});
  const fs::path path = scratch_file("round.ply", "");
  REQUIRE(write_ply(path, mesh));
  const auto back = read_ply(path);
  REQUIRE(back);
  CHECK(back->vertices == mesh.vertices);
  CHECK(back->triangles == mesh.triangles);
  fs::remove(path);
}

TEST_CASE("an ascii mesh with colours and quads is read as triangles") {
  const fs::path path = scratch_file("ascii.ply",
                                     "ply\nformat ascii 1.0\ncomment by hand\nelement vertex "
                                     "4\nproperty double x\nproperty double y\n"
                                     "property double z\nproperty uchar red\nelement face "
                                     "1\nproperty list uchar int vertex_index\nend_header\n"
                                     "0 0 0 255\n1 0 0 0\n1 1 0.5 0\n0 1 0 0\n4 0 1 2 3\n");
  const auto mesh = read_ply(path);
  REQUIRE(mesh);
  CHECK(mesh->vertices.size() == 4);
  CHECK(mesh->vertices[2] == Eigen::Vector3f(1.0F, 1.0F, 0.5F));
  REQUIRE(mesh->triangles.size() == 2);
  CHECK(mesh->triangles[1] == std::array<std::uint32_t, 3>{0, 2, 3});
  fs::remove(path);
}

TEST_CASE("a malformed mesh is refused with its place") {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto message = [](const std::string& text) {
    const fs::path path = scratch_file("bad.ply", text);
    const auto mesh = read_ply(path);
    fs::remove(path);
    return mesh ? std::string("no error") : mesh.error().message;
  };
  CHECK(message("plx\n").find("bad.ply:1:") != std::string::npos);
  CHECK(message("ply\nformat binary_big_endian 1.0\n").find("bad.ply:2:") != std::string::npos);
  CHECK(message(header + "0 0 zero\n").find("bad.ply:10:") != std::string::npos);
  CHECK(message(header + "0 0 0\n3 0 0 1\n").find("bad.ply:11:") != std::string::npos);
  CHECK(message(header).find("bad.ply:") != std::string::npos);
  CHECK(message("ply\nformat ascii 1.0\nelement vertex 1\n").find("end_header") !=
        std::string::npos);
  CHECK_FALSE(read_ply(fs::temp_directory_path() / "cloister-no-such.ply"));
}

}  // namespace
}  // namespace cloister
