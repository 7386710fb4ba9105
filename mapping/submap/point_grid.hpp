#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cloister {

/// A voxel-filtered point cloud: at most one point per cubic cell, the first that fell into it, found by its cell in
/// an open-addressing hash table of fixed capacity.
///
/// Coordinates must stay within +-1,000,000 cells of the origin.
/// Threads: one owner. Real-time: no allocation after construction; `clear` is O(1) by a generation count.
class PointGrid {
 public:
  /// @param max_points  most points it will hold; the table has twice as many places
  PointGrid(double cell_m, std::size_t max_points);

  void clear();
  /// Adds a point unless its cell has one or the grid is full. Returns true when it was added.
  bool insert(const Eigen::Vector3f& point);
  /// True when a point of the grid is closer than sqrt(3) cells: exact, by the cells within that distance.
  [[nodiscard]] bool has_neighbour(const Eigen::Vector3f& point) const;

  [[nodiscard]] std::size_t size() const { return num_points_; }
  [[nodiscard]] bool is_full() const { return num_points_ == max_points_; }
  [[nodiscard]] std::size_t bytes() const { return table_.size() * sizeof(Entry); }

 private:
  struct Entry {
    std::uint32_t generation = 0;
    Eigen::Vector3f point;
    std::uint64_t key = 0;
  };
  /// The entry of a key, or the free one where it would go.
  [[nodiscard]] std::size_t find(std::uint64_t key) const;

  float cells_per_metre_;
  float radius_squared_m2_;
  std::size_t max_points_;
  std::size_t num_points_ = 0;
  std::uint32_t generation_ = 1;
  std::vector<Entry> table_;
  std::vector<Eigen::Vector3i> offsets_;  ///< cells that can hold a neighbour, nearest first
};

}  // namespace cloister
