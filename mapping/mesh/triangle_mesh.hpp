#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cloister {

/// An indexed surface in a submap's frame S.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices_S;              ///< metres
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from free space
};

}  // namespace cloister
