#include "bench/simulate/convex_part.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace cloister {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

ConvexPart append(std::span<const Eigen::Vector3f> corners, std::span<const Triangle> triangles,
                  float albedo, TriangleMesh* mesh) {
  ConvexPart part{static_cast<std::uint32_t>(mesh->triangles.size()),
                  static_cast<std::uint32_t>(triangles.size()), corners[0], corners[0]};
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (const Eigen::Vector3f& corner : corners) {
    mesh->vertices.push_back(corner);
    part.min = part.min.cwiseMin(corner);
    part.max = part.max.cwiseMax(corner);
  }
  for (const Triangle& t : triangles) {
    mesh->triangles.push_back({first + t[0], first + t[1], first + t[2]});
    mesh->albedo.push_back(albedo);
  }
  return part;
}

}  // namespace

bool ConvexPart::contains(const TriangleMesh& mesh, const Eigen::Vector3f& p) const {
  if ((p.array() < min.array()).any() || (p.array() > max.array()).any()) return false;
  for (std::uint32_t k = first_triangle; k < first_triangle + num_triangles; ++k) {
    const Eigen::Vector3f& a = mesh.corner(k, 0);
    const Eigen::Vector3f normal = (mesh.corner(k, 1) - a).cross(mesh.corner(k, 2) - a);
    if (normal.dot(p - a) >= 0.0F) return false;
  }
  return true;
}

ConvexPart append_tetrahedron(std::array<Eigen::Vector3f, 4> corners, float albedo,
                              TriangleMesh* mesh) {
  const Eigen::Vector3f normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (normal.dot(corners[3] - corners[0]) > 0.0F) std::swap(corners[1], corners[2]);
  constexpr std::array<Triangle, 4> kFaces = {{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
  return append(corners, kFaces, albedo, mesh);
}

ConvexPart append_rod(const Eigen::Vector3f& from, float from_radius, const Eigen::Vector3f& to,
                      float to_radius, int sides, float albedo, TriangleMesh* mesh) {
  const Eigen::Vector3f along = (to - from).normalized();
  const Eigen::Vector3f u = along.unitOrthogonal();
  const Eigen::Vector3f v = along.cross(u);
  const auto n = static_cast<std::uint32_t>(sides);
  std::vector<Eigen::Vector3f> corners;
  for (std::uint32_t k = 0; k < 2 * n; ++k) {
    const float angle =
        2.0F * std::numbers::pi_v<float> * static_cast<float>(k % n) / static_cast<float>(sides);
    const Eigen::Vector3f spoke = std::cos(angle) * u + std::sin(angle) * v;
    corners.push_back(k < n ? Eigen::Vector3f(from + from_radius * spoke)
                            : Eigen::Vector3f(to + to_radius * spoke));
  }
  std::vector<Triangle> triangles;
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    triangles.push_back({k, next, n + next});
    triangles.push_back({k, n + next, n + k});
  }
  for (std::uint32_t k = 1; k + 1 < n; ++k) {
    triangles.push_back({0, k + 1, k});
    triangles.push_back({n, n + k, n + k + 1});
  }
  return append(corners, triangles, albedo, mesh);
}

ConvexPart append_roof(const Eigen::Vector3f& min, const Eigen::Vector3f& max, float albedo,
                       TriangleMesh* mesh) {
  const bool along_x = max.x() - min.x() >= max.y() - min.y();
  const Eigen::Vector3f middle = 0.5F * (min + max);
  const Eigen::Vector3f ridge_from(along_x ? min.x() : middle.x(), along_x ? middle.y() : min.y(),
                                   max.z());
  const Eigen::Vector3f ridge_to(along_x ? max.x() : middle.x(), along_x ? middle.y() : max.y(),
                                 max.z());
  // The four corners counter-clockwise from above, beginning so that 0 and 3 lie under ridge_from.
  std::array<Eigen::Vector3f, 6> corners = {Eigen::Vector3f(min),
                                            Eigen::Vector3f(max.x(), min.y(), min.z()),
                                            Eigen::Vector3f(max.x(), max.y(), min.z()),
                                            Eigen::Vector3f(min.x(), max.y(), min.z()),
                                            ridge_from,
                                            ridge_to};
  if (!along_x) corners = {corners[1], corners[2], corners[3], corners[0], ridge_from, ridge_to};
  constexpr std::array<Triangle, 8> kFaces = {
      {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {2, 3, 4}, {2, 4, 5}, {0, 4, 3}, {1, 2, 5}}};
  return append(corners, kFaces, albedo, mesh);
}

}  // namespace cloister
