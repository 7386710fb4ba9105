#include "firmware_interface/map/map_mesh.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/occupied_points.hpp"
#include "mapping/mesh/drawn_surfaces.hpp"
#include "mapping/mesh/marching_cubes.hpp"

namespace cloister {
namespace {

struct ParsedPly {
  std::vector<Eigen::Vector3d> points;
  std::vector<Rgb> colours;
  std::vector<std::int32_t> submaps;
  std::vector<std::array<std::int32_t, 3>> triangles;
  bool has_doubles = false;
};

/// Reads the PLY files that are written here, by their header.
ParsedPly parse_ply(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file.good());
  std::string line;
  std::size_t num_vertices = 0, num_faces = 0;
  ParsedPly ply;
  bool has_submap = false;
  REQUIRE(std::getline(file, line));
  REQUIRE(line == "ply");
  REQUIRE(std::getline(file, line));
  REQUIRE(line == "format binary_little_endian 1.0");
  while (std::getline(file, line) && line != "end_header") {
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "element" && second == "vertex") num_vertices = std::stoul(third);
    if (first == "element" && second == "face") num_faces = std::stoul(third);
    if (second == "double") ply.has_doubles = true;
    if (third == "submap") has_submap = true;
  }
  const auto read = [&](auto& value) { file.read(reinterpret_cast<char*>(&value), sizeof(value)); };
  for (std::size_t i = 0; i < num_vertices; ++i) {
    Eigen::Vector3d point;
    if (ply.has_doubles) {
      read(point);
    } else {
      Eigen::Vector3f single;
      read(single);
      point = single.cast<double>();
    }
    Rgb colour;
    read(colour);
    ply.points.push_back(point);
    ply.colours.push_back(colour);
    if (has_submap) read(ply.submaps.emplace_back());
  }
  for (std::size_t i = 0; i < num_faces; ++i) {
    std::uint8_t count = 0;
    read(count);
    REQUIRE(count == 3);
    read(ply.triangles.emplace_back());
  }
  REQUIRE(file.good());
  CHECK(file.peek() == std::ifstream::traits_type::eof());
  return ply;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void fill(MapBuilder& map) {
  map.fill_randomly(map.add_submap(12, pose_of(3, 2, 1, 0.5, 0.2)), 1, 60);
  map.fill_randomly(map.add_submap(5), 2, 60);
  map.add_submap(8);  // knows nothing
}

TEST_CASE("meshes come back from their files in M, coloured by submap") {
  MapBuilder map;
  fill(map);
  const ScratchDirectory directory;
  std::filesystem::create_directory(directory / "submaps");
  std::ofstream(directory / "submaps/77.ply") << "of an earlier run";
  std::ofstream(directory / "submaps/notes.txt") << "somebody's notes";
  REQUIRE(write_meshes(directory.path(), map.view()).has_value());
  CHECK(!std::filesystem::exists(directory / "submaps/77.ply"));
  CHECK(std::filesystem::exists(directory / "submaps/notes.txt"));

  const ParsedPly all = parse_ply(directory / "mesh.ply");
  std::size_t vertex = 0, triangle = 0;
  DrawnSurfaces drawn(map.store, map.info.voxel_size_m);
  for (const Submap* submap : sorted_submaps(map.view())) {
    const ParsedPly one =
        parse_ply(directory.path() / "submaps" / (std::to_string(submap->id) + ".ply"));
    TriangleMesh mesh =
        extract_mesh(map.store, submap->volume, map.info.voxel_size_m, kSurfaceDepth);
    drawn.leave_out(*submap, mesh);
    drawn.add(*submap);
    REQUIRE(one.points.size() == mesh.vertices_S.size());
    REQUIRE(one.triangles.size() == mesh.triangles.size());
    CHECK(mesh.triangles.empty() == (submap->id == 8));
    const std::size_t first_vertex = vertex;
    for (std::size_t i = 0; i < one.points.size(); ++i, ++vertex) {
      const Eigen::Vector3d expected = submap->T_M_S * mesh.vertices_S[i].cast<double>();
      REQUIRE((one.points[i] - expected).norm() < 1e-5);
      REQUIRE(one.colours[i] == submap_colour(submap->id));
      REQUIRE(all.points[vertex] == one.points[i]);
      REQUIRE(all.colours[vertex] == one.colours[i]);
    }
    for (std::size_t i = 0; i < one.triangles.size(); ++i, ++triangle) {
      for (int k = 0; k < 3; ++k) {
        REQUIRE(one.triangles[i][k] == static_cast<std::int32_t>(mesh.triangles[i][k]));
        REQUIRE(all.triangles[triangle][k] ==
                one.triangles[i][k] + static_cast<std::int32_t>(first_vertex));
      }
    }
  }
  CHECK(vertex == all.points.size());
  CHECK(triangle == all.triangles.size());
  CHECK(triangle > 5'000);

  REQUIRE(export_map(map.view(), directory / "exported.ply").has_value());
  CHECK(bytes_of(directory / "exported.ply") == bytes_of(directory / "mesh.ply"));
}

TEST_CASE("a map without a surface has meshes without triangles") {
  MapBuilder map;
  map.set_coarse(map.add_submap(0), {0, 0, 0}, -5);
  const ScratchDirectory directory;
  REQUIRE(write_meshes(directory.path(), map.view()).has_value());
  CHECK(parse_ply(directory / "mesh.ply").points.empty());
  CHECK(parse_ply(directory / "submaps/0.ply").points.empty());
}

TEST_CASE("a mesh far from M's origin keeps its shape") {
  MapBuilder map;
  Submap& submap = map.add_submap(0, pose_of(500'000, 5'400'000, 100, 0.3));
  map.fill_randomly(submap, 9, 30);
  const ScratchDirectory directory;
  REQUIRE(write_meshes(directory.path(), map.view()).has_value());
  const ParsedPly ply = parse_ply(directory / "mesh.ply");
  CHECK(ply.has_doubles);
  const TriangleMesh mesh =
      extract_mesh(map.store, submap.volume, map.info.voxel_size_m, kSurfaceDepth);
  REQUIRE(ply.points.size() == mesh.vertices_S.size());
  for (std::size_t i = 0; i < ply.points.size(); ++i) {
    const Eigen::Vector3d p_S = submap.T_M_S.inverse() * ply.points[i];
    REQUIRE((p_S - mesh.vertices_S[i].cast<double>()).norm() < 1e-6);
  }
}

TEST_CASE("meshes that cannot be written are reported") {
  MapBuilder map;
  fill(map);
  const ScratchDirectory directory;
  std::ofstream(directory / "file") << "in the way";
  const auto written = write_meshes(directory / "file", map.view());
  REQUIRE(!written.has_value());
  CHECK(written.error().kind == ErrorKind::kResource);
}

TEST_CASE("a cloud has one point at the centre of each occupied voxel") {
  MapBuilder map;
  fill(map);
  const ScratchDirectory directory;
  REQUIRE(export_map(map.view(), directory / "cloud.ply", {.cloud = true}).has_value());
  REQUIRE(export_map(map.view(), directory / "cloud.pcd").has_value());
  const ParsedPly ply = parse_ply(directory / "cloud.ply");
  const std::string pcd = bytes_of(directory / "cloud.pcd");
  const std::size_t body = pcd.find("DATA binary\n") + 12;
  REQUIRE(pcd.size() == body + 20 * count_occupied(map.view()));
  CHECK(pcd.find("POINTS " + std::to_string(ply.points.size()) + "\n") != std::string::npos);
  std::size_t i = 0;
  for_each_occupied_point(map.view(), [&](const Submap& submap, const Eigen::Vector3d& p_M) {
    REQUIRE(i < ply.points.size());
    REQUIRE((ply.points[i] - p_M).norm() < 1e-5);
    REQUIRE(ply.submaps[i] == submap.id);
    const Rgb colour = submap_colour(submap.id);
    REQUIRE(ply.colours[i] == colour);
    const Eigen::Vector3d p_voxel = submap.T_M_S.inverse() * p_M / map.info.voxel_size_m;
    const VoxelCoord voxel = p_voxel.array().floor().cast<int>();
    REQUIRE((p_voxel - (voxel.cast<double>().array() + 0.5).matrix()).norm() < 1e-9);
    REQUIRE(submap.volume.at(map.store, voxel) > 0);
    Eigen::Vector3f xyz;
    std::array<std::uint8_t, 4> bgr;
    std::uint32_t label = 0;
    std::memcpy(xyz.data(), &pcd[body + 20 * i], 12);
    std::memcpy(&bgr, &pcd[body + 20 * i + 12], 4);
    std::memcpy(&label, &pcd[body + 20 * i + 16], 4);
    REQUIRE(xyz == p_M.cast<float>());
    REQUIRE(Rgb{bgr[2], bgr[1], bgr[0]} == colour);
    REQUIRE(label == static_cast<std::uint32_t>(submap.id));
    ++i;
  });
  CHECK(i == ply.points.size());
  CHECK(i == count_occupied(map.view()));
}

TEST_CASE("an unknown suffix is refused with the known ones") {
  const MapBuilder map(0, 0);
  const ScratchDirectory directory;
  for (const char* name : {"map.stl", "map", "map.PLY"}) {
    const auto exported = export_map(map.view(), directory / name);
    REQUIRE(!exported.has_value());
    CHECK(exported.error().kind == ErrorKind::kUsage);
    for (const char* suffix : {".ply", ".pcd", ".bt", ".ot", ".vdb"}) {
      CHECK(exported.error().message.find(suffix) != std::string::npos);
    }
  }
  const auto cloud = export_map(map.view(), directory / "map.bt", {.cloud = true});
  CHECK(cloud.error().kind == ErrorKind::kUsage);
  CHECK(std::filesystem::is_empty(directory.path()));
}

}  // namespace
}  // namespace cloister
