#include "mapping/fuse/fusion_leftovers.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

namespace cloister {
namespace {

constexpr int kMinFreeVoxels = kOctantVoxels * 3 / 4;
constexpr int kLayersKept = 2;

constexpr std::array<std::array<int, 3>, 6> kSides = {
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

struct CoordHash {
  std::size_t operator()(const BlockCoord& c) const {
    return static_cast<std::size_t>(c.x()) * 73856093u ^
           static_cast<std::size_t>(c.y()) * 19349663u ^
           static_cast<std::size_t>(c.z()) * 83492791u;
  }
};

/// The voxels of a block that satisfy a condition on their value.
template <typename Condition>
BlockBits bits_where(const BlockView& view, Condition&& holds) {
  BlockBits bits{};
  if (view.block == nullptr) {
    if (!holds(view.coarse)) return bits;
    for (int octant = 0; octant < 8; ++octant) {
      if ((view.known >> octant & 1) == 0) continue;
      for (int z = 0; z < kOctantEdge; ++z)
        bits.word[octant_corner(octant).z() + z] |= octant_rows(octant);
    }
    return bits;
  }
  for (int i = 0; i < kBlockVoxels; ++i)
    bits.word[i >> 6] |= std::uint64_t{holds(view.block->voxels[i])} << (i & 63);
  return bits;
}

BlockBits free_bits(const BlockView& view) {
  return bits_where(view, [](LogOdds value) { return value < 0; });
}

constexpr std::uint64_t kLowX = 0x0101010101010101u, kHighX = kLowX << 7;

/// A set of voxels, and what of it reaches over a face into the block beside it.
void add_neighbours(const BlockBits& of, BlockBits& to) {
  for (int z = 0; z < kBlockEdge; ++z) {
    const std::uint64_t w = of.word[z];
    to.word[z] |= (w & ~kHighX) << 1 | (w & ~kLowX) >> 1 | w << kBlockEdge | w >> kBlockEdge;
    if (z > 0) to.word[z] |= of.word[z - 1];
    if (z + 1 < kBlockEdge) to.word[z] |= of.word[z + 1];
  }
}

void add_neighbours_across(const BlockBits& beside, int side, BlockBits& to) {
  constexpr int kLast = kBlockEdge - 1, kLastRow = kBlockEdge * kLast;
  if (side == 4) to.word[0] |= beside.word[kLast];
  if (side == 5) to.word[kLast] |= beside.word[0];
  if (side >= 4) return;
  for (int z = 0; z < kBlockEdge; ++z) {
    const std::uint64_t w = beside.word[z];
    to.word[z] |= side == 0   ? w >> kLast & kLowX
                  : side == 1 ? w << kLast & kHighX
                  : side == 2 ? w >> kLastRow
                              : w << kLastRow;
  }
}

/// A block with occupied voxels.
struct Solid {
  BlockCoord coord;
  BlockBits occupied;  ///< that no layer has reached yet
  BlockBits layer;     ///< the outermost that was found last; before the first, free space
  BlockBits interior;
  std::array<std::int32_t, 6> beside;  ///< indices of the solid blocks at its sides, or -1
};

std::vector<Solid> solids_of(const VoxelStore& store, const Volume& volume) {
  std::vector<Solid> solids;
  volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    const BlockBits occupied = bits_where(view, [](LogOdds value) { return value > 0; });
    if (occupied.any()) solids.push_back({coord, occupied, free_bits(view), {}, {}});
  });
  std::unordered_map<BlockCoord, std::int32_t, CoordHash> index;
  index.reserve(solids.size());
  for (std::size_t i = 0; i < solids.size(); ++i)
    index.emplace(solids[i].coord, static_cast<std::int32_t>(i));
  for (Solid& solid : solids) {
    for (std::size_t side = 0; side < kSides.size(); ++side) {
      const auto found = index.find(solid.coord + BlockCoord(kSides[side].data()));
      solid.beside[side] = found == index.end() ? -1 : found->second;
    }
  }
  return solids;
}

/// The occupied voxels beside the last layer become the next one. @return false when there are none
bool find_next_layer(const VoxelStore& store, const Volume& volume, bool is_first,
                     std::vector<Solid>& solids, std::vector<BlockBits>& next) {
  bool is_any = false;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Solid& solid = solids[i];
    BlockBits reached{};
    add_neighbours(solid.layer, reached);
    for (int side = 0; side < static_cast<int>(kSides.size()); ++side) {
      const auto at = static_cast<std::size_t>(side);
      if (solid.beside[at] >= 0) {
        add_neighbours_across(solids[static_cast<std::size_t>(solid.beside[at])].layer, side,
                              reached);
      } else if (is_first) {
        const BlockView view = volume.view(store, solid.coord + BlockCoord(kSides[at].data()));
        add_neighbours_across(free_bits(view), side, reached);
      }
    }
    for (int z = 0; z < kBlockEdge; ++z) next[i].word[z] = reached.word[z] & solid.occupied.word[z];
    is_any = is_any || next[i].any();
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    solids[i].layer = next[i];
    for (int z = 0; z < kBlockEdge; ++z) solids[i].occupied.word[z] &= ~next[i].word[z];
  }
  return is_any;
}

bool is_occupied_somewhere(const Block& block) {
  return *std::max_element(block.voxels, block.voxels + kBlockVoxels) > 0;
}

}  // namespace

std::size_t forget_wall_interiors(VoxelPools& pools, Volume& volume) {
  std::vector<Solid> solids = solids_of(pools.store, volume);
  std::vector<BlockBits> next(solids.size());
  for (int layer = 1; find_next_layer(pools.store, volume, layer == 1, solids, next); ++layer) {
    if (layer <= kLayersKept) continue;
    for (Solid& solid : solids) {
      for (int z = 0; z < kBlockEdge; ++z) solid.interior.word[z] |= solid.layer.word[z];
    }
  }
  const std::size_t blocks_before = volume.num_blocks();
  for (const Solid& solid : solids) {
    if (!solid.interior.any()) continue;
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, solid.coord, &chunk);  // is there: it is known
    // A coarse node takes no memory: it stays.
    if (!Volume::has_block(*place)) continue;
    Block& block = pools.store.block(Volume::block_index(*place));
    for (int i = 0; i < kBlockVoxels; ++i) {
      if ((solid.interior.word[i >> 6] >> (i & 63) & 1) != 0) block.voxels[i] = kUnknownLogOdds;
    }
    (void)volume.settle_block(pools, *chunk, *place);
  }
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
    std::array<int, 8> num_free{};
    for (int i = 0; i < kBlockVoxels; ++i)
      num_free[static_cast<std::size_t>(octant_of(i))] += block.voxels[i] < 0;
    unsigned free = 0;
    LogOdds weakest = std::numeric_limits<LogOdds>::min();
    for (int octant = 0; octant < 8; ++octant)
      free |= static_cast<unsigned>(num_free[static_cast<std::size_t>(octant)] >= kMinFreeVoxels)
              << octant;
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (block.voxels[i] < 0 && (free >> octant_of(i) & 1) != 0)
        weakest = std::max(weakest, block.voxels[i]);
    }
    volume.set_coarse(pools, *chunk, *place, free != 0 ? weakest : kUnknownLogOdds,
                      static_cast<OctantMask>(free));
  }
  volume.release_empty_chunks(pools);
  return bare.size();
}

}  // namespace cloister
