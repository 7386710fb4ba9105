#include "bench/simulate/path_writer.hpp"

#include <algorithm>

namespace cloister {

std::vector<Eigen::Vector3d> densify(const std::vector<Waypoint>& path, double spacing_m) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 1; k < path.size(); ++k) {
    const Eigen::Vector3d a = path[k - 1].position_W;
    const Eigen::Vector3d b = path[k].position_W;
    const int count = std::max(1, static_cast<int>((b - a).norm() / spacing_m));
    for (int n = 0; n <= count; ++n) points.push_back(a + (b - a) * n / count);
  }
  return points;
}

}  // namespace cloister
