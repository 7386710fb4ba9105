#include "mapping/submap/point_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cloister {

PointGrid::PointGrid(double cell_m, std::size_t max_points)
    : cells_per_metre_(static_cast<float>(1.0 / cell_m)),
      radius_squared_m2_(static_cast<float>(3.0 * cell_m * cell_m)),
      max_points_(max_points),
      table_(std::bit_ceil(2 * max_points + 1)) {
  // A neighbour closer than sqrt(3) cells lies at most two cells away along each axis.
  for (std::int32_t z = -2; z <= 2; ++z) {
    for (std::int32_t y = -2; y <= 2; ++y) {
      for (std::int32_t x = -2; x <= 2; ++x) offsets_.push_back({x, y, z});
    }
  }
  const auto distance = [](const Cell& c) { return c[0] * c[0] + c[1] * c[1] + c[2] * c[2]; };
  std::stable_sort(offsets_.begin(), offsets_.end(),
                   [&](const Cell& a, const Cell& b) { return distance(a) < distance(b); });
}

void PointGrid::clear() {
  num_points_ = 0;
  if (++generation_ == 0) {
    std::fill(table_.begin(), table_.end(), Entry{});
    generation_ = 1;
  }
}

PointGrid::Cell PointGrid::cell_of(const Eigen::Vector3f& point) const {
  return {static_cast<std::int32_t>(std::floor(point.x() * cells_per_metre_)),
          static_cast<std::int32_t>(std::floor(point.y() * cells_per_metre_)),
          static_cast<std::int32_t>(std::floor(point.z() * cells_per_metre_))};
}

std::uint64_t PointGrid::key_of(std::int32_t x, std::int32_t y, std::int32_t z) {
  constexpr std::int32_t kOffset = 1 << 20;
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(x + kOffset) & kMask) |
         ((static_cast<std::uint64_t>(y + kOffset) & kMask) << 21) |
         ((static_cast<std::uint64_t>(z + kOffset) & kMask) << 42);
}

std::size_t PointGrid::find(std::uint64_t key) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t place = (key * 0x9e3779b97f4a7c15ull >> 20) & mask;
  while (table_[place].generation == generation_ && table_[place].key != key) place = (place + 1) & mask;
  return place;
}

bool PointGrid::insert(const Eigen::Vector3f& point) {
  const Cell cell = cell_of(point);
  const std::uint64_t key = key_of(cell[0], cell[1], cell[2]);
  Entry& entry = table_[find(key)];
  if (entry.generation == generation_ || is_full()) return false;
  entry = {generation_, point, key};
  ++num_points_;
  return true;
}

bool PointGrid::has_neighbour(const Eigen::Vector3f& point) const {
  const Cell cell = cell_of(point);
  for (const Cell& offset : offsets_) {
    const Entry& entry = table_[find(key_of(cell[0] + offset[0], cell[1] + offset[1], cell[2] + offset[2]))];
    if (entry.generation == generation_ && (entry.point - point).squaredNorm() < radius_squared_m2_) return true;
  }
  return false;
}

}  // namespace cloister
