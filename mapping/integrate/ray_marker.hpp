#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "mapping/scan/deskew.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What one scan says about one block, one bit a voxel (bit x + 8 y of word z).
struct BlockMarks {
  std::uint64_t free[kBlockEdge];
  std::uint64_t hit[kBlockEdge];
};

/// Turns the rays of one scan into sets of voxels, each voxel at most once: crossed (free) and hit. Rays of a scan
/// cross the same voxels near the sensor dozens of times; marking a bit is cheap, updating a map is not.
///
/// All memory is taken at construction: a dense window of chunks around the sensor, and marks for `max_blocks`
/// blocks. What does not fit is declined and counted.
/// Threads: one owner. Real-time: no allocation after construction.
class RayMarker {
 public:
  struct Marked {
    BlockCoord coord;
    BlockMarks marks;
  };

  /// @param max_range_m  longest ray, metres, from anywhere within `slack_m` of the window's centre
  RayMarker(double voxel_size_m, double max_range_m, double slack_m, std::size_t max_blocks);

  /// Marks all rays. Blocks come out in the order in which the rays first reach them.
  void mark(const std::vector<Ray>& rays, const Eigen::Vector3f& centre_S);

  [[nodiscard]] std::size_t num_blocks() const { return num_blocks_; }
  [[nodiscard]] const Marked& block(std::size_t i) const { return blocks_[i]; }
  /// Rays that were cut short because the window or the marks were full.
  [[nodiscard]] std::size_t num_declined() const { return num_declined_; }

 private:
  [[nodiscard]] BlockMarks* find_or_make(const BlockCoord& block);
  [[nodiscard]] bool walk(const Ray& ray);
  void clear();

  using Slot = std::uint32_t;  ///< 0 = none, else index + 1
  float voxels_per_metre_;
  int window_edge_;                         ///< chunks
  ChunkCoord window_origin_;                ///< lowest chunk of the window
  std::vector<Slot> window_;                ///< [edge^3] chunk -> entry of chunk_slots_
  std::vector<std::uint32_t> used_chunks_;  ///< entries of window_ in use
  std::unique_ptr<Slot[]> chunk_slots_;     ///< [max chunks x 512] block -> entry of blocks_; emptied when first used
  std::unique_ptr<Marked[]> blocks_;
  std::size_t max_blocks_;
  std::size_t max_chunks_;
  std::size_t num_blocks_ = 0;
  std::size_t num_declined_ = 0;
};

}  // namespace cloister
