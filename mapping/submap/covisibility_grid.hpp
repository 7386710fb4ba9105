#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cloister {

/// Counts, cell by cell, in how many of a sequence of scans a place was seen.
///
/// A place counts as established when it was seen in at least a given share of the scans since it was first seen.
/// What a sensor glimpses of the next room through a door is another sliver from every position, and never gets
/// established; the room it is in, a corridor ahead or an open square do.
///
/// Threads: one owner. Real-time: no allocation after construction; `clear` is O(1) by a generation count.
class CovisibilityGrid {
 public:
  /// @param cell_m      coarser than the distance between neighbouring beams where it matters
  /// @param min_share   of the scans since a cell was first seen, 0 to 1
  CovisibilityGrid(double cell_m, double min_share, std::size_t max_cells);

  /// A share of fewer scans than these says nothing: until then a cell must have been seen in a share of all scans.
  static constexpr std::uint32_t kMinScans = 4;

  void clear();
  /// Counts one scan. Points of one cell count once; cells beyond the capacity are not counted.
  void add(const std::vector<Eigen::Vector3f>& points);
  [[nodiscard]] bool is_established(const Eigen::Vector3f& point) const;
  [[nodiscard]] std::uint32_t num_scans() const { return num_scans_; }
  [[nodiscard]] std::size_t bytes() const { return table_.size() * sizeof(Entry); }

 private:
  struct Entry {
    std::uint64_t key = 0;
    std::uint32_t generation = 0;
    std::uint32_t num_seen = 0;
    std::uint32_t first_scan = 0;
    std::uint32_t last_scan = 0;
  };
  [[nodiscard]] std::size_t find(const Eigen::Vector3f& point, std::uint64_t& key) const;

  float cells_per_metre_;
  double min_share_;
  std::size_t max_cells_;
  std::size_t num_cells_ = 0;
  std::uint32_t generation_ = 1;
  std::uint32_t num_scans_ = 0;
  std::vector<Entry> table_;
};

}  // namespace cloister
