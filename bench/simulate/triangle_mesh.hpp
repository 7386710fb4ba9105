#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cloister {

/// A triangle soup in one frame, metres. Corners run counter-clockwise seen from outside the solid.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float>
      albedo;  ///< share of light sent back, 0 to 1, per triangle; empty = the same everywhere

  [[nodiscard]] const Eigen::Vector3f& corner(std::size_t triangle, int k) const {
    return vertices[triangles[triangle][static_cast<std::size_t>(k)]];
  }
};

}  // namespace cloister
