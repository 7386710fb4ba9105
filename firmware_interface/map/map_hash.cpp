#include "firmware_interface/map/map_hash.hpp"

#include <vector>

#include "firmware_interface/map/chunk_record.hpp"
#include "firmware_interface/map/content_hash.hpp"
#include "firmware_interface/map/map_contents.hpp"

namespace cloister {

std::uint64_t map_hash(const VoxelStore& store, std::span<const Submap* const> submaps) {
  ContentHash hash;
  for (const Submap* submap : sorted_submaps({{}, &store, submaps})) {
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T_M_S = submap->T_M_S.affine();
    const std::vector<const Chunk*> chunks = sorted_chunks(store, submap->volume);
    hash.add_value(submap->id);
    hash.add(T_M_S.data(), 12 * sizeof(double));
    hash.add_value<std::uint64_t>(chunks.size());
    for (const Chunk* chunk : chunks) {
      hash.add_value(make_chunk_record(*chunk));
      for (const std::uint32_t place : chunk->places) {
        if (Volume::has_block(place)) hash.add_value(store.block(Volume::block_index(place)));
      }
    }
  }
  return hash.digest();
}

}  // namespace cloister
