#include "bench/simulate/facade.hpp"

#include <cmath>

#include "bench/simulate/building.hpp"

namespace cloister {

namespace {

constexpr double kFoundation = -2.0;
constexpr double kPlinth = 0.5;
constexpr double kRecess = 0.25;
constexpr double kStorey = 3.2;
constexpr double kCornice = 0.4;
constexpr float kGlass = 0.2F;

std::vector<Opening> windows_between(double from, double to, double bay_m, bool at_ground,
                                     RandomStream* random) {
  std::vector<Opening> openings;
  const int count = static_cast<int>(std::floor((to - from - 1.0) / bay_m));
  const double first = 0.5 * (from + to) - 0.5 * (count - 1) * bay_m;
  for (int k = 0; k < count; ++k) {
    const double chance = random->uniform();
    if (chance < 0.08) continue;
    const bool is_door = at_ground && chance > 0.88;
    openings.push_back({first + k * bay_m, is_door ? 1.5 : 1.3, is_door ? 0.0 : 0.6, 2.4});
  }
  return openings;
}

}  // namespace

void append_block(const Block& b, RandomStream* random, std::vector<BoxSolid>* solids) {
  const auto stone = static_cast<float>(random->uniform(0.4, 0.6));
  const std::array<double, 4> depth = {
      b.has_windows[0] ? kRecess : 0.0, b.has_windows[1] ? kRecess : 0.0,
      b.has_windows[2] ? kRecess : 0.0, b.has_windows[3] ? kRecess : 0.0};
  const auto box = [&](double x0, double y0, double z0, double x1, double y1, double z1,
                       float albedo) {
    solids->push_back(BoxSolid::from_corners_m({x0, y0, z0}, {x1, y1, z1}, albedo));
  };
  box(b.min_x, b.min_y, kFoundation, b.max_x, b.max_y, kPlinth, stone);
  box(b.min_x + depth[3], b.min_y + depth[0], kPlinth, b.max_x - depth[1], b.max_y - depth[2],
      b.height_m, kGlass);
  const int storeys = static_cast<int>(std::floor((b.height_m - kPlinth - kCornice) / kStorey));
  for (int side = 0; side < 4; ++side) {
    if (!b.has_windows[static_cast<std::size_t>(side)]) continue;
    const bool along_x = side % 2 == 0;
    const double from = along_x ? b.min_x : b.min_y + depth[0];
    const double to = along_x ? b.max_x : b.max_y - depth[2];
    const std::array<double, 4> outside = {b.min_y, b.max_x, b.max_y, b.min_x};
    const double inwards = side == 0 || side == 3 ? 0.5 * kRecess : -0.5 * kRecess;
    const double line = outside[static_cast<std::size_t>(side)] + inwards;
    for (int storey = 0; storey < storeys; ++storey) {
      append_wall({along_x, line, from, to, kPlinth + storey * kStorey, kStorey, kRecess,
                   windows_between(from, to, b.bay_m, storey == 0, random)},
                  stone, solids);
    }
    append_wall({along_x,
                 line,
                 from,
                 to,
                 kPlinth + storeys * kStorey,
                 b.height_m - kPlinth - storeys * kStorey,
                 kRecess,
                 {}},
                stone, solids);
  }
}

}  // namespace cloister
