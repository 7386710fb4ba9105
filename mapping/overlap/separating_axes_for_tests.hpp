#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "mapping/overlap/oriented_box.hpp"

namespace cloister {

/// The widest gap [m] along the 15 axes of the separating-axis theorem: the boxes meet exactly when it is not
/// positive. Slow and obvious, and nothing of it is shared with the code under test.
inline double separating_axis_gap_m(const OrientedBox& a, const OrientedBox& b) {
  std::vector<Eigen::Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(a.R_M_S.col(i));
    axes.push_back(b.R_M_S.col(i));
    for (int j = 0; j < 3; ++j) axes.push_back(a.R_M_S.col(i).cross(b.R_M_S.col(j)));
  }
  double widest_m = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& axis : axes) {
    if (axis.norm() < 1e-9) continue;  // parallel edges: the faces' normals cover them
    const auto interval = [direction = axis.normalized().eval()](const OrientedBox& box) {
      double low = std::numeric_limits<double>::infinity();
      double high = -low;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                                   (corner & 4) != 0 ? 1.0 : -1.0);
        const double p =
            direction.dot(box.centre_M + box.R_M_S * sign.cwiseProduct(box.half_extents_m));
        low = std::min(low, p);
        high = std::max(high, p);
      }
      return std::pair{low, high};
    };
    const auto [a_low, a_high] = interval(a);
    const auto [b_low, b_high] = interval(b);
    widest_m = std::max({widest_m, a_low - b_high, b_low - a_high});
  }
  return widest_m;
}

}  // namespace cloister
