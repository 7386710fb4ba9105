#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware_interface/files/atomic_file.hpp"
#include "firmware_interface/output/submap_colour.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/mesh/triangle_mesh.hpp"

namespace cloister {

/// How a PLY file holds coordinates. A float is good to a millimetre as far as 10 km from the
/// origin; a map that lies farther out (some graphs use projected coordinates) needs doubles.
enum class PlyReal { kFloat, kDouble };

struct PlyMeshSize {
  std::uint64_t num_vertices = 0;
  std::uint64_t num_triangles = 0;
};

/// A mesh file is its header, then the vertices (x y z in M, red green blue) of all its meshes,
/// then their triangles (one byte 3, three ints), binary little-endian.
[[nodiscard]] std::string ply_mesh_header(const PlyMeshSize& size, PlyReal real);
inline constexpr std::size_t kPlyTriangleBytes = 1 + 3 * sizeof(std::int32_t);
[[nodiscard]] constexpr std::size_t ply_vertex_bytes(PlyReal real) {
  return 3 * (real == PlyReal::kFloat ? sizeof(float) : sizeof(double)) + 3;
}

/// The writers below only append; a failure sticks to the file and is reported by its commit.
void write_ply_vertices(const TriangleMesh& mesh, const Pose& T_M_S, Rgb colour, PlyReal real,
                        AtomicFile& file);
/// @param first_vertex  number of vertices that other meshes have put into the file before
void write_ply_triangles(const TriangleMesh& mesh, std::uint64_t first_vertex, AtomicFile& file);

/// A cloud file is its header, then points (x y z in M, red green blue, int submap).
[[nodiscard]] std::string ply_cloud_header(std::uint64_t num_points, PlyReal real);
void write_ply_point(const Eigen::Vector3d& p_M, Rgb colour, std::int32_t submap, PlyReal real,
                     AtomicFile& file);

}  // namespace cloister
