#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "bench/simulate/triangle_mesh.hpp"

namespace cloister {

/// Uneven ground over a rectangle with a corner at the origin: heights on a square grid, two
/// triangles a cell. What lies below it is solid.
struct HeightField {
  double spacing_m = 1.0;
  int num_x = 0;                ///< vertices along x
  int num_y = 0;                ///< vertices along y
  std::vector<float> height_m;  ///< [num_y x num_x], row-major

  /// Samples a height function of (x, y) on the grid.
  [[nodiscard]] static HeightField sample(
      double size_x_m, double size_y_m, double spacing_m,
      const std::function<double(double x, double y)>& height_at);

  /// Height of the triangle above or below (x, y); outside the rectangle that of its rim.
  [[nodiscard]] double at(double x, double y) const;

  /// Below the ground; false outside the rectangle.
  [[nodiscard]] bool is_below(const Eigen::Vector3d& p) const;

  /// Appends the sheet, facing up; `albedo_at` is asked once per cell, at its middle.
  void append_to(const std::function<float(double x, double y)>& albedo_at,
                 TriangleMesh* mesh) const;
};

}  // namespace cloister
