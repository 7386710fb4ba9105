#include "bench/simulate/building.hpp"

#include <algorithm>

namespace cloister {

void append_wall(const Wall& wall, float albedo, std::vector<BoxSolid>* solids) {
  const double half = 0.5 * wall.thickness_m;
  const double top = wall.foot_m + wall.height_m;
  const auto add = [&](double from, double to, double low, double high) {
    if (to - from < 1e-3 || high - low < 1e-3) return;
    const Eigen::Vector3d a = wall.along_x ? Eigen::Vector3d(from, wall.line_m - half, low)
                                           : Eigen::Vector3d(wall.line_m - half, from, low);
    const Eigen::Vector3d b = wall.along_x ? Eigen::Vector3d(to, wall.line_m + half, high)
                                           : Eigen::Vector3d(wall.line_m + half, to, high);
    solids->push_back(BoxSolid::from_corners_m(a, b, albedo));
  };
  std::vector<Opening> openings = wall.openings;
  std::sort(openings.begin(), openings.end(),
            [](const Opening& a, const Opening& b) { return a.center_m < b.center_m; });
  double at = wall.from_m;
  for (const Opening& opening : openings) {
    const double left = opening.center_m - 0.5 * opening.width_m;
    const double right = opening.center_m + 0.5 * opening.width_m;
    add(at, left, wall.foot_m, top);
    add(left, right, wall.foot_m, wall.foot_m + opening.bottom_m);
    add(left, right, wall.foot_m + opening.top_m, top);
    at = right;
  }
  add(at, wall.to_m, wall.foot_m, top);
}

void append_slab_with_hole(const BoxSolid& slab, const BoxSolid& hole,
                           std::vector<BoxSolid>* solids) {
  const auto add = [&](int min_x, int min_y, int max_x, int max_y) {
    if (min_x >= max_x || min_y >= max_y) return;
    solids->push_back(
        {{min_x, min_y, slab.min_mm.z()}, {max_x, max_y, slab.max_mm.z()}, slab.albedo});
  };
  add(slab.min_mm.x(), slab.min_mm.y(), hole.min_mm.x(), slab.max_mm.y());
  add(hole.max_mm.x(), slab.min_mm.y(), slab.max_mm.x(), slab.max_mm.y());
  add(hole.min_mm.x(), slab.min_mm.y(), hole.max_mm.x(), hole.min_mm.y());
  add(hole.min_mm.x(), hole.max_mm.y(), hole.max_mm.x(), slab.max_mm.y());
}

}  // namespace cloister
