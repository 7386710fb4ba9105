#include "mapping/fuse/fusion_leftovers.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

#include "mapping/fuse/block_halo.hpp"

namespace cloister {
namespace {

/// The occupied voxels of a volume that a surface needs (see forget_wall_interiors).
class SurfaceVoxels {
 public:
  SurfaceVoxels(const VoxelStore& store, const Volume& volume) {
    volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
      const BlockBits occupied = occupied_bits(view);
      if (occupied.any()) solids_.push_back({coord, occupied, free_bits(view), {}, {}, {}});
    });
    std::unordered_map<BlockCoord, const Solid*, BlockCoordHash> index;
    index.reserve(solids_.size());
    for (const Solid& solid : solids_) index.emplace(solid.coord, &solid);
    for (Solid& solid : solids_) {
      const Halo free = halo_of([&](std::size_t k) {
        const BlockCoord coord = solid.coord + offset_around(k);
        const auto found = index.find(coord);
        solid.around[k] = found == index.end() ? nullptr : found->second;
        return solid.around[k] == nullptr ? free_bits(volume.view(store, coord)) : solid.around[k]->free;
      });
      solid.front = both(beside(free), solid.occupied);
      solid.touching_free = both(touching(free), solid.occupied);
    }
    for (Solid& solid : solids_) {
      if (!solid.touching_free.any()) {
        solid.occupied = {};
        continue;
      }
      const BlockBits behind = touching(halo_of([&](std::size_t k) {
        return solid.around[k] == nullptr ? BlockBits{} : solid.around[k]->front;
      }));
      for (int z = 0; z < kBlockEdge; ++z)
        solid.occupied.word[z] &= solid.touching_free.word[z] | behind.word[z];
    }
  }

  /// Calls `visit(BlockCoord, BlockBits)` for every block with occupied voxels, with those that a surface needs.
  template <typename Visitor>
  void for_each_block(Visitor&& visit) const {
    for (const Solid& solid : solids_) visit(solid.coord, solid.occupied);
  }

 private:
  /// A block with occupied voxels.
  struct Solid {
    BlockCoord coord;
    BlockBits occupied;       ///< at the end, only those that are needed
    BlockBits free;
    BlockBits front;          ///< those with a face in common with free space
    BlockBits touching_free;  ///< those with as much as a corner in common with it
    std::array<const Solid*, kBlocksAround> around;  ///< by offset; null where nothing is occupied
  };

  std::vector<Solid> solids_;
};

bool is_occupied_somewhere(const Block& block) {
  return *std::max_element(block.voxels, block.voxels + kBlockVoxels) > 0;
}

}  // namespace

std::size_t forget_wall_interiors(VoxelPools& pools, Volume& volume) {
  const std::size_t blocks_before = volume.num_blocks();
  const SurfaceVoxels surfaces(pools.store, volume);
  surfaces.for_each_block([&](const BlockCoord& coord, const BlockBits& needed) {
    // A coarse node takes no memory: it stays.
    if (volume.view(pools.store, coord).block != nullptr) forget_occupied(pools, volume, coord, needed);
  });
  volume.release_empty_chunks(pools);
  return blocks_before - volume.num_blocks();
}

std::size_t settle_free_space(VoxelPools& pools, Volume& volume) {
  std::vector<BlockCoord> bare;
  volume.for_each_block(pools.store, [&](const BlockCoord& coord, const BlockView& view) {
    if (view.block != nullptr && !is_occupied_somewhere(*view.block)) bare.push_back(coord);
  });
  for (const BlockCoord& coord : bare) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, coord, &chunk);  // is there: it is known
    const Block& block = pools.store.block(Volume::block_index(*place));
    const OctantMask free = octants_seen_free({&block, kUnknownLogOdds, kNoOctants});
    LogOdds weakest = std::numeric_limits<LogOdds>::min();
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (block.voxels[i] < 0 && (free >> octant_of(i) & 1) != 0)
        weakest = std::max(weakest, block.voxels[i]);
    }
    volume.set_coarse(pools, *chunk, *place, free != 0 ? weakest : kUnknownLogOdds, free);
  }
  volume.release_empty_chunks(pools);
  return bare.size();
}

OctantMask octants_seen_free(const BlockView& view) {
  std::array<int, 8> num_free{};
  for (int i = 0; i < kBlockVoxels; ++i) num_free[static_cast<std::size_t>(octant_of(i))] += view.at(i) < 0;
  unsigned free = 0;
  for (int octant = 0; octant < 8; ++octant)
    free |= static_cast<unsigned>(num_free[static_cast<std::size_t>(octant)] >= kOctantVoxels - kMaxUnseenVoxels)
            << octant;
  return static_cast<OctantMask>(free);
}

void forget_occupied(VoxelPools& pools, Volume& volume, const BlockCoord& coord, const BlockBits& needed) {
  Chunk* chunk = nullptr;
  std::uint32_t* place = volume.make_place(pools, coord, &chunk);  // is there: it is known
  Block& block = pools.store.block(Volume::block_index(*place));
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (block.voxels[i] > 0 && (needed.word[i >> 6] >> (i & 63) & 1) == 0) block.voxels[i] = kUnknownLogOdds;
  }
  (void)volume.settle_block(pools, *chunk, *place);
}

}  // namespace cloister
