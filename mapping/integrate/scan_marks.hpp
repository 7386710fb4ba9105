#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "mapping/scan/scan_beams.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What one scan has marked: sets of voxels that its beams hit, and, for scans that are integrated beam by beam, that
/// they crossed. However many beams pass a voxel, it is marked once.
///
/// All memory is taken at construction: a dense window of chunks around the sensor, and marks for `max_blocks` blocks.
/// What does not fit is declined and counted.
/// Threads: one owner. Real-time: no allocation after construction.
class ScanMarks {
 public:
  struct Marked {
    BlockCoord coord;
    bool is_applied;  ///< for whoever visits blocks in another order
    BlockBits hit;
    BlockBits crossed;
  };
  using Slot = std::uint32_t;  ///< 0 = none, else index + 1

  /// @param max_range_m  longest beam, metres, from anywhere within `slack_m` of the window's centre
  ScanMarks(double voxel_size_m, double max_range_m, double slack_m, std::size_t max_blocks);

  /// Forgets all marks and moves the window to the sensor.
  void restart(const Eigen::Vector3f& centre_S);
  /// Marks the voxels of all returns as hit.
  void mark_returns(const ScanBeams& scan);
  /// Marks the voxels that a ray crosses up to its free length, each that it enters.
  void mark_crossed(const Ray& ray);

  /// Blocks in the order in which they were first marked.
  [[nodiscard]] std::size_t num_blocks() const { return num_blocks_; }
  [[nodiscard]] Marked& block(std::size_t i) { return blocks_[i]; }
  /// The slots of a chunk's blocks, [512], or null when none is marked.
  [[nodiscard]] const Slot* find_chunk(const ChunkCoord& chunk) const;
  [[nodiscard]] Marked& in_slot(Slot slot) { return blocks_[slot - 1]; }
  /// Returns and rays that were cut short because the window or the marks were full.
  [[nodiscard]] std::size_t num_declined() const { return num_declined_; }

 private:
  [[nodiscard]] Marked* find_or_make(const BlockCoord& block);
  [[nodiscard]] std::size_t window_index(const ChunkCoord& chunk) const;

  float voxels_per_metre_;
  int window_edge_;                         ///< chunks
  ChunkCoord window_origin_;                ///< lowest chunk of the window
  std::vector<Slot> window_;                ///< [edge^3] chunk -> entry of chunk_slots_
  std::vector<std::uint32_t> used_chunks_;  ///< entries of window_ in use
  std::unique_ptr<Slot[]>
      chunk_slots_;  ///< [max chunks x 512] block -> entry of blocks_; emptied when first used
  std::unique_ptr<Marked[]> blocks_;
  std::size_t max_blocks_;
  std::size_t max_chunks_;
  std::size_t num_blocks_ = 0;
  std::size_t num_declined_ = 0;
};

}  // namespace cloister
