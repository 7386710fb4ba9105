#include "firmware_interface/map/chunk_record.hpp"

#include <algorithm>
#include <tuple>

namespace cloister {

ChunkRecord make_chunk_record(const Chunk& chunk) {
  ChunkRecord record{chunk.x, chunk.y, chunk.z, {}, {}, {}};
  for (int i = 0; i < kChunkBlocks; ++i) {
    if (Volume::has_block(chunk.places[i])) {
      record.has_block[i >> 3] |= static_cast<std::uint8_t>(1u << (i & 7));
    } else {
      record.coarse[i] = Volume::coarse_value(chunk.places[i]);
      record.known[i] = Volume::known_octants(chunk.places[i]);
    }
  }
  return record;
}

std::vector<const Chunk*> sorted_chunks(const VoxelStore& store, const Volume& volume) {
  std::vector<const Chunk*> chunks;
  chunks.reserve(volume.num_chunks());
  for (PoolIndex index = volume.first_chunk(); index != kNoIndex;
       index = store.chunk(index).next_in_volume) {
    if (store.chunk(index).num_known > 0) chunks.push_back(&store.chunk(index));
  }
  std::sort(chunks.begin(), chunks.end(), [](const Chunk* a, const Chunk* b) {
    return std::tuple(a->z, a->y, a->x) < std::tuple(b->z, b->y, b->x);
  });
  return chunks;
}

}  // namespace cloister
