#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mapping/voxel/voxel.hpp"
#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// The occupancy volume of one submap: a hash table of chunks, each with 8x8x8 places that hold a coarse node (one value
/// for those octants of the block that are known, or nothing) or the index of a block in the store.
///
/// Invariant: `num_blocks` and `num_chunks` count what the volume took from the pools and has not given back.
/// Threads: one owner at a time. Readers need the owner's permission (it is lent through a queue).
/// Real-time: no member allocates from the heap; blocks and chunks come from the caller's VoxelPools.
class Volume {
 public:
  Volume() { buckets_.fill(kNoIndex); }
  Volume(const Volume&) = delete;
  Volume& operator=(const Volume&) = delete;
  Volume(Volume&& other) noexcept { swap(other); }
  Volume& operator=(Volume&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(Volume& other) noexcept;

  // Reading.
  [[nodiscard]] LogOdds at(const VoxelStore& store, const VoxelCoord& voxel) const;
  [[nodiscard]] BlockView view(const VoxelStore& store, const BlockCoord& block) const;
  /// The chunk at a coordinate, or kNoIndex.
  [[nodiscard]] PoolIndex find_chunk(const VoxelStore& store, const ChunkCoord& coord) const;
  [[nodiscard]] PoolIndex first_chunk() const { return first_chunk_; }

  /// Calls `visit(BlockCoord, BlockView)` for every known block, chunk by chunk, newest chunk first.
  template <typename Visitor>
  void for_each_block(const VoxelStore& store, Visitor&& visit) const;

  // Writing.
  /// The place of a block; its chunk is made when missing. Null when the pool of chunks is empty.
  [[nodiscard]] std::uint32_t* make_place(VoxelPools& pools, const BlockCoord& block,
                                          Chunk** chunk);
  /// The block at a place, split from its coarse node if need be. Null when the pool of blocks is empty.
  [[nodiscard]] Block* make_block(VoxelPools& pools, Chunk& chunk, std::uint32_t& place);
  /// Sets a place to one value for all voxels of some octants, the others being unknown; returns its block, if it had
  /// one, to the pool.
  void set_coarse(VoxelPools& pools, Chunk& chunk, std::uint32_t& place, LogOdds value,
                  OctantMask known);
  /// Turns the block at a place into a coarse node if it has become one: nothing occupied, and each octant free or
  /// unknown throughout (the weakest value stays); or all voxels occupied. Returns true if it did.
  bool settle_block(VoxelPools& pools, Chunk& chunk, std::uint32_t& place);
  /// Takes the block out of a place without returning it to the pool: it now belongs to the caller.
  [[nodiscard]] PoolIndex detach_block(Chunk& chunk, std::uint32_t& place);
  /// Puts a block that the caller owns into an unknown place.
  void attach_block(Chunk& chunk, std::uint32_t& place, PoolIndex block);
  /// Returns the chunks in which nothing is known any more.
  void release_empty_chunks(VoxelPools& pools);
  /// Returns everything to the pools.
  void clear(VoxelPools& pools);

  // Size.
  [[nodiscard]] std::size_t num_blocks() const { return num_blocks_; }
  [[nodiscard]] std::size_t num_chunks() const { return num_chunks_; }
  /// Places of which anything is known, blocks and coarse nodes. O(chunks).
  [[nodiscard]] std::size_t num_known(const VoxelStore& store) const;
  /// All bytes this volume owns: blocks, chunks and its own table.
  [[nodiscard]] std::size_t bytes() const {
    return num_blocks_ * sizeof(Block) + num_chunks_ * sizeof(Chunk) + sizeof(Volume);
  }

  // Places: the top bit tells a block's index from a coarse node, whose low byte is its value and whose second byte says
  // which octants are known. The second bit of a block's place is a note for who integrates: the block rests, as it
  // has hardly changed of late. Nobody else heeds it.
  static constexpr std::uint32_t kBlockFlag = 0x80000000u;
  static constexpr std::uint32_t kRestFlag = 0x40000000u;
  [[nodiscard]] static constexpr bool has_block(std::uint32_t place) {
    return (place & kBlockFlag) != 0;
  }
  [[nodiscard]] static constexpr PoolIndex block_index(std::uint32_t place) {
    return place & ~(kBlockFlag | kRestFlag);
  }
  [[nodiscard]] static constexpr bool rests(std::uint32_t place) {
    return place >= (kBlockFlag | kRestFlag);
  }
  static constexpr void set_rest(std::uint32_t& block_place, bool rests) {
    block_place = (block_place & ~kRestFlag) | (rests ? kRestFlag : 0);
  }
  [[nodiscard]] static constexpr LogOdds coarse_value(std::uint32_t place) {
    return static_cast<LogOdds>(static_cast<std::uint8_t>(place));
  }
  [[nodiscard]] static constexpr OctantMask known_octants(std::uint32_t place) {
    return static_cast<OctantMask>(place >> 8);
  }
  /// Nothing at all, if either says so.
  [[nodiscard]] static constexpr std::uint32_t coarse_place(LogOdds value, OctantMask known) {
    if (value == kUnknownLogOdds || known == kNoOctants) return 0;
    return static_cast<std::uint8_t>(value) | std::uint32_t{known} << 8;
  }
  [[nodiscard]] static BlockView view_of(const VoxelStore& store, std::uint32_t place) {
    if (has_block(place)) return {&store.block(block_index(place)), kUnknownLogOdds, kNoOctants};
    return {nullptr, coarse_value(place), known_octants(place)};
  }

 private:
  static constexpr std::size_t kNumBuckets = 1024;
  [[nodiscard]] static std::size_t bucket_of(int x, int y, int z);

  std::array<PoolIndex, kNumBuckets> buckets_;
  PoolIndex first_chunk_ = kNoIndex;
  std::uint32_t num_chunks_ = 0;
  std::uint32_t num_blocks_ = 0;
};

template <typename Visitor>
void Volume::for_each_block(const VoxelStore& store, Visitor&& visit) const {
  for (PoolIndex index = first_chunk_; index != kNoIndex;
       index = store.chunk(index).next_in_volume) {
    const Chunk& chunk = store.chunk(index);
    for (int i = 0; i < kChunkBlocks; ++i) {
      if (chunk.places[i] == 0) continue;
      const BlockCoord coord(chunk.x * kChunkEdge + (i & 7), chunk.y * kChunkEdge + ((i >> 3) & 7),
                             chunk.z * kChunkEdge + (i >> 6));
      visit(coord, view_of(store, chunk.places[i]));
    }
  }
}

}  // namespace cloister
