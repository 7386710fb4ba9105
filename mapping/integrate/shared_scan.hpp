#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/integrate/projective.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/scan/range_image.hpp"

namespace cloister {

/// Threads that somebody lends to one scan: there are none in mapping/.
class ScanWorkers {
 public:
  virtual ~ScanWorkers() = default;
  /// How many there are, with the one that calls.
  [[nodiscard]] virtual int num() const = 0;
  /// Calls task(context, worker) for each worker from 0, at the same time, and returns when all are done: what was written
  /// before is seen by them, and what they wrote afterwards.
  virtual void run(void (*task)(void* context, int worker), void* context) = 0;
};

/// A chunk that a scan asks.
struct ChunkTask {
  VoxelCoord corner;
  const RangeImage::ColumnPose*
      pose;  ///< from where it is seen, and how well one pose tells (see NodePose)
  float pose_share;
  bool is_free;  ///< it is seen through as a whole
};

/// What a scan says about a block, found out by a worker and done by the thread that owns the pools.
struct BlockDecision {
  enum class Kind : std::uint8_t {
    kOctants,  ///< of a coarse node, some are free
    kFree,     ///< a block with voxels is seen through as a whole
    kVoxels    ///< each was looked up
  };
  ChunkCoord chunk;
  std::uint16_t index;  ///< in the chunk
  std::uint8_t turns;   ///< of scans that ask the chunk
  Kind kind;
  OctantMask octants;               ///< for kOctants
  const ScanMarks::Marked* marked;  ///< for kVoxels: the returns, or null
  BlockBits free, crossed;          ///< for kVoxels
};

/// The decisions of one worker. Real-time: no allocation after construction.
class BlockDecisions {
 public:
  explicit BlockDecisions(std::size_t capacity) : decisions_(capacity) {}

  void clear() { size_ = 0; }
  /// Is there room for all blocks of another chunk?
  [[nodiscard]] bool takes_chunk() const { return decisions_.size() - size_ >= kChunkBlocks; }
  [[nodiscard]] BlockDecision& add() { return decisions_[size_++]; }
  [[nodiscard]] std::span<const BlockDecision> all() const { return {decisions_.data(), size_}; }

 private:
  static constexpr std::size_t kChunkBlocks = kChunkEdge * kChunkEdge * kChunkEdge;

  std::vector<BlockDecision> decisions_;
  std::size_t size_ = 0;
};

/// One worker's part: every so many-th chunk.
struct ScanShare {
  std::size_t next = 0;  ///< of its chunks, the first that is left
  BlockDecisions decisions;
  ProjectiveResult result;
};

/// What several threads need to share a scan. Reading the volume and deciding is theirs; changing it is left to one.
struct SharedScan {
  /// A worker's decisions have room for some 16,000 blocks: where there are more, it takes another round.
  explicit SharedScan(ScanWorkers& lent)
      : workers(lent),
        shares(static_cast<std::size_t>(std::max(1, lent.num())),
               ScanShare{0, BlockDecisions(1 << 14), {}}) {
    chunks.reserve(1 << 14);
  }

  ScanWorkers& workers;
  std::vector<ChunkTask> chunks;  ///< to be asked
  std::vector<ScanShare> shares;  ///< [workers]
};

}  // namespace cloister
