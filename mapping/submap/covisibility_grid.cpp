#include "mapping/submap/covisibility_grid.hpp"

#include <algorithm>
#include <bit>

#include "mapping/submap/cell_key.hpp"

namespace cloister {
CovisibilityGrid::CovisibilityGrid(double cell_m, double min_share, std::size_t max_cells)
    : cells_per_metre_(static_cast<float>(1.0 / cell_m)),
      min_share_(min_share),
      max_cells_(max_cells),
      table_(std::bit_ceil(2 * max_cells + 1)) {}

void CovisibilityGrid::clear() {
  num_cells_ = 0;
  num_scans_ = 0;
  if (++generation_ == 0) {
    std::fill(table_.begin(), table_.end(), Entry{});
    generation_ = 1;
  }
}

std::size_t CovisibilityGrid::find(const Eigen::Vector3f& point, std::uint64_t& key) const {
  const Eigen::Vector3i cell = cell_of(point, cells_per_metre_);
  key = cell_key(cell.x(), cell.y(), cell.z());
  std::size_t place = first_place(key, table_.size());
  while (table_[place].generation == generation_ && table_[place].key != key) place = (place + 1) & (table_.size() - 1);
  return place;
}

void CovisibilityGrid::add(const std::vector<Eigen::Vector3f>& points) {
  ++num_scans_;
  for (const Eigen::Vector3f& point : points) {
    std::uint64_t key = 0;
    Entry& entry = table_[find(point, key)];
    if (entry.generation != generation_) {
      if (num_cells_ == max_cells_) continue;
      ++num_cells_;
      entry = {key, generation_, 0, num_scans_, 0};
    }
    if (entry.last_scan == num_scans_) continue;
    entry.last_scan = num_scans_;
    ++entry.num_seen;
  }
}

bool CovisibilityGrid::is_established(const Eigen::Vector3f& point) const {
  std::uint64_t key = 0;
  const Entry& entry = table_[find(point, key)];
  if (entry.generation != generation_) return false;
  const std::uint32_t num_since = num_scans_ - entry.first_scan + 1;
  const std::uint32_t num_asked = std::max(num_since, std::min(num_scans_, kMinScans));
  return entry.num_seen >= min_share_ * num_asked;
}

}  // namespace cloister
