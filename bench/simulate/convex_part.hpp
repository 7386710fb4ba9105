#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "bench/simulate/triangle_mesh.hpp"

namespace cloister {

/// A closed convex piece of a mesh that is no axis-aligned block: a range of its triangles.
struct ConvexPart {
  std::uint32_t first_triangle = 0;
  std::uint32_t num_triangles = 0;
  Eigen::Vector3f min = Eigen::Vector3f::Zero();  ///< bounds
  Eigen::Vector3f max = Eigen::Vector3f::Zero();

  [[nodiscard]] bool contains(const TriangleMesh& mesh, const Eigen::Vector3f& p) const;
};

/// Appends a tetrahedron; its corners may come in any order.
[[nodiscard]] ConvexPart append_tetrahedron(std::array<Eigen::Vector3f, 4> corners, float albedo,
                                            TriangleMesh* mesh);

/// Appends a straight, tapered rod with a regular outline of `sides` corners.
[[nodiscard]] ConvexPart append_rod(const Eigen::Vector3f& from, float from_radius,
                                    const Eigen::Vector3f& to, float to_radius, int sides,
                                    float albedo, TriangleMesh* mesh);

/// Appends a ridge roof over a rectangle: the ridge runs along the rectangle's longer side.
[[nodiscard]] ConvexPart append_roof(const Eigen::Vector3f& min, const Eigen::Vector3f& max,
                                     float albedo, TriangleMesh* mesh);

}  // namespace cloister
