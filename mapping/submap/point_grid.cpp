#include "mapping/submap/point_grid.hpp"

#include <algorithm>
#include <bit>

#include "mapping/submap/cell_key.hpp"

namespace cloister {

PointGrid::PointGrid(double cell_m, std::size_t max_points)
    : cells_per_metre_(static_cast<float>(1.0 / cell_m)),
      radius_squared_m2_(static_cast<float>(3.0 * cell_m * cell_m)),
      max_points_(max_points),
      table_(std::bit_ceil(2 * max_points + 1)) {
  // A neighbour closer than sqrt(3) cells lies at most two cells away along each axis.
  for (std::int32_t z = -2; z <= 2; ++z) {
    for (std::int32_t y = -2; y <= 2; ++y) {
      for (std::int32_t x = -2; x <= 2; ++x) offsets_.emplace_back(x, y, z);
    }
  }
  std::stable_sort(offsets_.begin(), offsets_.end(), [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return a.squaredNorm() < b.squaredNorm();
  });
}

void PointGrid::clear() {
  num_points_ = 0;
  if (++generation_ == 0) {
    std::fill(table_.begin(), table_.end(), Entry{});
    generation_ = 1;
  }
}

std::size_t PointGrid::find(std::uint64_t key) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t place = first_place(key, table_.size());
  while (table_[place].generation == generation_ && table_[place].key != key) place = (place + 1) & mask;
  return place;
}

bool PointGrid::insert(const Eigen::Vector3f& point) {
  const Eigen::Vector3i cell = cell_of(point, cells_per_metre_);
  const std::uint64_t key = cell_key(cell.x(), cell.y(), cell.z());
  Entry& entry = table_[find(key)];
  if (entry.generation == generation_ || is_full()) return false;
  entry = {generation_, point, key};
  ++num_points_;
  return true;
}

bool PointGrid::has_neighbour(const Eigen::Vector3f& point) const {
  const Eigen::Vector3i cell = cell_of(point, cells_per_metre_);
  for (const Eigen::Vector3i& offset : offsets_) {
    const Eigen::Vector3i near = cell + offset;
    const Entry& entry = table_[find(cell_key(near.x(), near.y(), near.z()))];
    if (entry.generation == generation_ && (entry.point - point).squaredNorm() < radius_squared_m2_) return true;
  }
  return false;
}

}  // namespace cloister
