#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <vector>

#include "mapping/voxel/volume.hpp"

namespace cloister {

static_assert(std::endian::native == std::endian::little,
              "map files are little-endian, and written as memory holds them");

/// A chunk as the map file and the map hash see it: free of pool indices.
struct ChunkRecord {
  std::int32_t x, y, z;                       ///< chunk coordinate
  std::array<LogOdds, kChunkBlocks> coarse;   ///< a coarse node's value; 0 where a place has a block
  std::array<OctantMask, kChunkBlocks> known; ///< octants that have it; 0 where a place has a block
  std::array<std::uint8_t, kChunkBlocks / 8>
      has_block;  ///< bit i & 7 of byte i >> 3; the blocks follow in this order

  [[nodiscard]] bool is_block(int place_idx) const {
    return (has_block[place_idx >> 3] >> (place_idx & 7) & 1) != 0;
  }
};
static_assert(sizeof(ChunkRecord) == 12 + 2 * kChunkBlocks + kChunkBlocks / 8);

[[nodiscard]] ChunkRecord make_chunk_record(const Chunk& chunk);

/// The volume's chunks in the order z, y, x of their coordinates; chunks that know nothing are left
/// out.
[[nodiscard]] std::vector<const Chunk*> sorted_chunks(const VoxelStore& store,
                                                      const Volume& volume);

}  // namespace cloister
