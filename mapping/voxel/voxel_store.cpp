#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

VoxelStore::VoxelStore(std::size_t num_blocks, std::size_t num_chunks)
    : num_blocks_(num_blocks),
      num_chunks_(num_chunks),
      blocks_(std::make_unique_for_overwrite<Block[]>(num_blocks)),
      chunks_(std::make_unique_for_overwrite<Chunk[]>(num_chunks)) {}

void VoxelPools::take_all() {
  // Released in descending order, so that items are handed out from the front of the store on.
  for (std::size_t i = store.num_blocks(); i-- > 0;) blocks.release(static_cast<PoolIndex>(i));
  for (std::size_t i = store.num_chunks(); i-- > 0;) chunks.release(static_cast<PoolIndex>(i));
}

}  // namespace cloister
