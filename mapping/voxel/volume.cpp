#include "mapping/voxel/volume.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace cloister {
namespace {

void set_place(Chunk& chunk, std::uint32_t& place, std::uint32_t value) {
  chunk.num_known += static_cast<std::uint32_t>(place == 0 && value != 0);
  chunk.num_known -= static_cast<std::uint32_t>(place != 0 && value == 0);
  place = value;
}

}  // namespace

void Volume::swap(Volume& other) noexcept {
  std::swap(buckets_, other.buckets_);
  std::swap(first_chunk_, other.first_chunk_);
  std::swap(num_chunks_, other.num_chunks_);
  std::swap(num_blocks_, other.num_blocks_);
}

std::size_t Volume::bucket_of(int x, int y, int z) {
  // Three odd multipliers spread neighbouring chunks; the high bits are the well-mixed ones.
  const std::uint32_t mixed = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^
                              static_cast<std::uint32_t>(y) * 0x85ebca77u ^
                              static_cast<std::uint32_t>(z) * 0xc2b2ae3du;
  return (mixed * 0x27d4eb2fu) >> 22;
}
static_assert(1u << (32 - 22) == 1024, "bucket_of must cover kNumBuckets");

PoolIndex Volume::find_chunk(const VoxelStore& store, const ChunkCoord& coord) const {
  PoolIndex index = buckets_[bucket_of(coord.x(), coord.y(), coord.z())];
  while (index != kNoIndex) {
    const Chunk& chunk = store.chunk(index);
    if (chunk.x == coord.x() && chunk.y == coord.y() && chunk.z == coord.z()) break;
    index = chunk.next_in_bucket;
  }
  return index;
}

BlockView Volume::view(const VoxelStore& store, const BlockCoord& block) const {
  const PoolIndex index = find_chunk(store, parent_coord(block));
  if (index == kNoIndex) return {};
  return view_of(store, store.chunk(index).places[index_in_block(block)]);
}

LogOdds Volume::at(const VoxelStore& store, const VoxelCoord& voxel) const {
  return view(store, parent_coord(voxel)).at(index_in_block(voxel));
}

std::uint32_t* Volume::make_place(VoxelPools& pools, const BlockCoord& block, Chunk** chunk) {
  const ChunkCoord coord = parent_coord(block);
  PoolIndex index = find_chunk(pools.store, coord);
  if (index == kNoIndex) {
    index = pools.chunks.try_acquire();
    if (index == kNoIndex) return nullptr;
    PoolIndex& bucket = buckets_[bucket_of(coord.x(), coord.y(), coord.z())];
    Chunk& fresh = pools.store.chunk(index);
    fresh.x = coord.x();
    fresh.y = coord.y();
    fresh.z = coord.z();
    fresh.num_known = 0;
    fresh.next_in_bucket = bucket;
    fresh.next_in_volume = first_chunk_;
    std::memset(fresh.places, 0, sizeof(fresh.places));
    bucket = index;
    first_chunk_ = index;
    ++num_chunks_;
  }
  *chunk = &pools.store.chunk(index);
  return &(*chunk)->places[index_in_block(block)];
}

Block* Volume::make_block(VoxelPools& pools, Chunk& chunk, std::uint32_t& place) {
  if (has_block(place)) return &pools.store.block(block_index(place));
  const PoolIndex index = pools.blocks.try_acquire();
  if (index == kNoIndex) return nullptr;
  Block& block = pools.store.block(index);
  const BlockView node = view_of(pools.store, place);
  if (node.is_uniform()) {
    std::memset(block.voxels, node.coarse, sizeof(block.voxels));
  } else {
    for (int i = 0; i < kBlockVoxels; i += kOctantEdge)
      std::memset(block.voxels + i, node.at(i), kOctantEdge);
  }
  set_place(chunk, place, kBlockFlag | index);
  ++num_blocks_;
  return &block;
}

void Volume::set_coarse(VoxelPools& pools, Chunk& chunk, std::uint32_t& place, LogOdds value,
                        OctantMask known) {
  if (has_block(place)) {
    pools.blocks.release(block_index(place));
    --num_blocks_;
  }
  set_place(chunk, place, coarse_place(value, known));
}

bool Volume::settle_block(VoxelPools& pools, Chunk& chunk, std::uint32_t& place) {
  if (!has_block(place)) return false;
  const Block& block = pools.store.block(block_index(place));
  LogOdds lowest[8], highest[8];
  for (int octant = 0; octant < 8; ++octant) {
    const int first = index_in_block(octant_corner(octant));
    lowest[octant] = highest[octant] = block.voxels[first];
    for (int z = 0; z < kOctantEdge; ++z) {
      for (int y = 0; y < kOctantEdge; ++y) {
        const LogOdds* row = block.voxels + first + index_in_block(0, y, z);
        for (int x = 0; x < kOctantEdge; ++x) {
          lowest[octant] = std::min(lowest[octant], row[x]);
          highest[octant] = std::max(highest[octant], row[x]);
        }
      }
    }
  }
  if (*std::min_element(lowest, lowest + 8) > 0) {
    set_coarse(pools, chunk, place, *std::min_element(lowest, lowest + 8), kAllOctants);
    return true;
  }
  LogOdds weakest = std::numeric_limits<LogOdds>::min();
  unsigned known = 0;
  for (int octant = 0; octant < 8; ++octant) {
    const bool is_unknown = lowest[octant] == kUnknownLogOdds && highest[octant] == kUnknownLogOdds;
    if (!is_unknown && highest[octant] >= 0) return false;
    if (is_unknown) continue;
    known |= 1u << octant;
    weakest = std::max(weakest, highest[octant]);
  }
  set_coarse(pools, chunk, place, weakest, static_cast<OctantMask>(known));
  return true;
}

PoolIndex Volume::detach_block(Chunk& chunk, std::uint32_t& place) {
  const PoolIndex index = block_index(place);
  set_place(chunk, place, 0);
  --num_blocks_;
  return index;
}

void Volume::attach_block(Chunk& chunk, std::uint32_t& place, PoolIndex block) {
  set_place(chunk, place, kBlockFlag | block);
  ++num_blocks_;
}

std::size_t Volume::num_known(const VoxelStore& store) const {
  std::size_t sum = 0;
  for (PoolIndex index = first_chunk_; index != kNoIndex; index = store.chunk(index).next_in_volume)
    sum += store.chunk(index).num_known;
  return sum;
}

void Volume::release_empty_chunks(VoxelPools& pools) {
  PoolIndex* link = &first_chunk_;
  while (*link != kNoIndex) {
    const PoolIndex index = *link;
    Chunk& chunk = pools.store.chunk(index);
    if (chunk.num_known > 0) {
      link = &chunk.next_in_volume;
      continue;
    }
    PoolIndex* in_bucket = &buckets_[bucket_of(chunk.x, chunk.y, chunk.z)];
    while (*in_bucket != index) in_bucket = &pools.store.chunk(*in_bucket).next_in_bucket;
    *in_bucket = chunk.next_in_bucket;
    *link = chunk.next_in_volume;
    pools.chunks.release(index);
    --num_chunks_;
  }
}

void Volume::clear(VoxelPools& pools) {
  for (PoolIndex index = first_chunk_; index != kNoIndex;) {
    Chunk& chunk = pools.store.chunk(index);
    for (const std::uint32_t place : chunk.places) {
      if (has_block(place)) pools.blocks.release(block_index(place));
    }
    const PoolIndex next = chunk.next_in_volume;
    pools.chunks.release(index);
    index = next;
  }
  buckets_.fill(kNoIndex);
  first_chunk_ = kNoIndex;
  num_chunks_ = 0;
  num_blocks_ = 0;
}

}  // namespace cloister
