#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// Handle of a block or a chunk in its store.
using PoolIndex = std::uint32_t;
inline constexpr PoolIndex kNoIndex = 0xffffffffu;

/// 8x8x8 places for blocks (4.16 m at 6.5 cm). Chunks of one volume hang in its hash buckets as linked lists.
///
/// A place is a coarse node (0 = unknown) or the index of a block: see `Volume`.
struct Chunk {
  std::int32_t x, y, z;          ///< chunk coordinate
  PoolIndex next_in_bucket;      ///< chain of the volume's hash bucket
  PoolIndex next_in_volume;      ///< list of all chunks of the volume, newest first
  std::uint32_t num_known;       ///< places that are not unknown
  std::uint32_t places[kChunkBlocks];
};

/// One owner's share of a pool: the free items that it may hand out, and a count of what it has.
///
/// Threads: one owner at a time, who alone calls it. Shares of one pool exchange items only through their owners.
/// Real-time: `try_acquire` and `release` never allocate; the list is sized for the whole pool at construction.
class PoolShare {
 public:
  explicit PoolShare(std::size_t pool_capacity) { free_.reserve(pool_capacity); }

  /// Hands out the item released last, or kNoIndex when none is left.
  [[nodiscard]] PoolIndex try_acquire() {
    if (free_.empty()) return kNoIndex;
    const PoolIndex index = free_.back();
    free_.pop_back();
    if (index >= num_used_) num_used_ = index + 1;
    return index;
  }
  void release(PoolIndex index) { free_.push_back(index); }

  [[nodiscard]] std::size_t num_free() const { return free_.size(); }
  /// One more than the highest index handed out so far: the memory behind it has not been touched by this owner.
  [[nodiscard]] std::size_t num_used() const { return num_used_; }

 private:
  std::vector<PoolIndex> free_;
  std::size_t num_used_ = 0;
};

/// The memory of all blocks and chunks, taken once at construction and never again.
///
/// Threads: the store itself is read-only bookkeeping; an item belongs to whoever acquired it from a PoolShare.
class VoxelStore {
 public:
  VoxelStore(std::size_t num_blocks, std::size_t num_chunks);

  [[nodiscard]] std::size_t num_blocks() const { return num_blocks_; }
  [[nodiscard]] std::size_t num_chunks() const { return num_chunks_; }

  [[nodiscard]] Block& block(PoolIndex index) { return blocks_[index]; }
  [[nodiscard]] const Block& block(PoolIndex index) const { return blocks_[index]; }
  [[nodiscard]] Chunk& chunk(PoolIndex index) { return chunks_[index]; }
  [[nodiscard]] const Chunk& chunk(PoolIndex index) const { return chunks_[index]; }

 private:
  std::size_t num_blocks_;
  std::size_t num_chunks_;
  std::unique_ptr<Block[]> blocks_;
  std::unique_ptr<Chunk[]> chunks_;
};

/// The shares of one owner (a thread) in a store.
struct VoxelPools {
  explicit VoxelPools(VoxelStore& voxel_store)
      : store(voxel_store), blocks(voxel_store.num_blocks()), chunks(voxel_store.num_chunks()) {}

  VoxelStore& store;
  PoolShare blocks;
  PoolShare chunks;

  /// Puts every item of the store into this share. Call once, for the first owner.
  void take_all();
};

}  // namespace cloister
