#include "bench/simulate/box_solid.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {

namespace {

struct Rectangle {
  int min_u, min_v, max_u, max_v;
};

/// What is left of a rectangle when another is cut out: up to four pieces, appended to `out`.
void subtract(const Rectangle& from, const Rectangle& cut, std::vector<Rectangle>* out) {
  const Rectangle common{std::max(from.min_u, cut.min_u), std::max(from.min_v, cut.min_v),
                         std::min(from.max_u, cut.max_u), std::min(from.max_v, cut.max_v)};
  if (common.min_u >= common.max_u || common.min_v >= common.max_v) {
    out->push_back(from);
    return;
  }
  if (from.min_u < common.min_u) out->push_back({from.min_u, from.min_v, common.min_u, from.max_v});
  if (common.max_u < from.max_u) out->push_back({common.max_u, from.min_v, from.max_u, from.max_v});
  if (from.min_v < common.min_v)
    out->push_back({common.min_u, from.min_v, common.max_u, common.min_v});
  if (common.max_v < from.max_v)
    out->push_back({common.min_u, common.max_v, common.max_u, from.max_v});
}

void append_rectangle(const Rectangle& r, int axis, int level_mm, bool faces_up, float albedo,
                      TriangleMesh* mesh) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  const int corners[4][2] = {
      {r.min_u, r.min_v}, {r.max_u, r.min_v}, {r.max_u, r.max_v}, {r.min_u, r.max_v}};
  for (const auto& corner : corners) {
    Eigen::Vector3d point;
    point[axis] = level_mm * 1e-3;
    point[u] = corner[0] * 1e-3;
    point[v] = corner[1] * 1e-3;
    mesh->vertices.push_back(point.cast<float>());
  }
  // (axis, u, v) is right-handed: u then v turns counter-clockwise seen from the axis's positive
  // side.
  if (faces_up) {
    mesh->triangles.push_back({first, first + 1, first + 2});
    mesh->triangles.push_back({first, first + 2, first + 3});
  } else {
    mesh->triangles.push_back({first, first + 2, first + 1});
    mesh->triangles.push_back({first, first + 3, first + 2});
  }
  mesh->albedo.insert(mesh->albedo.end(), 2, albedo);
}

/// True when `other` hides the face of `box` (its part inside the other's outline): it fills the
/// space in front of the face, or it has the same face and comes first.
bool hides(const BoxSolid& other, int axis, int level_mm, bool faces_up, bool comes_first) {
  const int low = other.min_mm[axis];
  const int high = other.max_mm[axis];
  if (faces_up) return (low <= level_mm && level_mm < high) || (comes_first && high == level_mm);
  return (low < level_mm && level_mm <= high) || (comes_first && low == level_mm);
}

}  // namespace

BoxSolid BoxSolid::from_corners_m(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  float albedo) {
  const auto to_mm = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3i((p * 1e3).array().round().cast<int>());
  };
  return {to_mm(a.cwiseMin(b)), to_mm(a.cwiseMax(b)), albedo};
}

bool BoxSolid::contains(const Eigen::Vector3d& point_m) const {
  return (point_m.array() > min_m().array()).all() && (point_m.array() < max_m().array()).all();
}

double BoxSolid::distance_m(const Eigen::Vector3d& point_m) const {
  return (point_m - point_m.cwiseMax(min_m()).cwiseMin(max_m())).norm();
}

TriangleMesh union_surface(std::span<const BoxSolid> boxes) {
  TriangleMesh mesh;
  std::vector<Rectangle> visible;
  std::vector<Rectangle> next;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const BoxSolid& box = boxes[i];
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      for (const bool faces_up : {false, true}) {
        const int level_mm = faces_up ? box.max_mm[axis] : box.min_mm[axis];
        visible.assign(1, {box.min_mm[u], box.min_mm[v], box.max_mm[u], box.max_mm[v]});
        for (std::size_t j = 0; j < boxes.size() && !visible.empty(); ++j) {
          const BoxSolid& other = boxes[j];
          if (j == i || !hides(other, axis, level_mm, faces_up, j < i)) continue;
          next.clear();
          for (const Rectangle& part : visible) {
            subtract(part, {other.min_mm[u], other.min_mm[v], other.max_mm[u], other.max_mm[v]},
                     &next);
          }
          visible.swap(next);
        }
        for (const Rectangle& part : visible) {
          append_rectangle(part, axis, level_mm, faces_up, box.albedo, &mesh);
        }
      }
    }
  }
  return mesh;
}

}  // namespace cloister
