#include "bench/simulate/height_field.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {

HeightField HeightField::sample(double size_x_m, double size_y_m, double spacing_m,
                                const std::function<double(double x, double y)>& height_at) {
  HeightField field;
  field.spacing_m = spacing_m;
  field.num_x = static_cast<int>(std::lround(size_x_m / spacing_m)) + 1;
  field.num_y = static_cast<int>(std::lround(size_y_m / spacing_m)) + 1;
  for (int j = 0; j < field.num_y; ++j) {
    for (int i = 0; i < field.num_x; ++i) {
      field.height_m.push_back(static_cast<float>(height_at(i * spacing_m, j * spacing_m)));
    }
  }
  return field;
}

double HeightField::at(double x, double y) const {
  const double u = std::clamp(x / spacing_m, 0.0, num_x - 1.0);
  const double v = std::clamp(y / spacing_m, 0.0, num_y - 1.0);
  const int i = std::min(static_cast<int>(u), num_x - 2);
  const int j = std::min(static_cast<int>(v), num_y - 2);
  const double fu = u - i;
  const double fv = v - j;
  const float* row = &height_m[static_cast<std::size_t>(j) * num_x + i];
  const double z00 = row[0];
  const double z10 = row[1];
  const double z01 = row[num_x];
  const double z11 = row[num_x + 1];
  // Cells are cut from (0, 0) to (1, 1).
  return fu >= fv ? z00 + fu * (z10 - z00) + fv * (z11 - z10)
                  : z00 + fv * (z01 - z00) + fu * (z11 - z01);
}

bool HeightField::is_below(const Eigen::Vector3d& p) const {
  const bool is_over = p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= (num_x - 1) * spacing_m &&
                       p.y() <= (num_y - 1) * spacing_m;
  return is_over && p.z() < at(p.x(), p.y());
}

void HeightField::append_to(const std::function<float(double x, double y)>& albedo_at,
                            TriangleMesh* mesh) const {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  const auto width = static_cast<std::uint32_t>(num_x);
  for (int j = 0; j < num_y; ++j) {
    for (int i = 0; i < num_x; ++i) {
      mesh->vertices.emplace_back(static_cast<float>(i * spacing_m),
                                  static_cast<float>(j * spacing_m),
                                  height_m[static_cast<std::size_t>(j) * num_x + i]);
    }
  }
  for (int j = 0; j + 1 < num_y; ++j) {
    for (int i = 0; i + 1 < num_x; ++i) {
      const std::uint32_t v00 =
          first + static_cast<std::uint32_t>(j) * width + static_cast<std::uint32_t>(i);
      mesh->triangles.push_back({v00, v00 + 1, v00 + width + 1});
      mesh->triangles.push_back({v00, v00 + width + 1, v00 + width});
      mesh->albedo.insert(mesh->albedo.end(), 2,
                          albedo_at((i + 0.5) * spacing_m, (j + 0.5) * spacing_m));
    }
  }
}

}  // namespace cloister
