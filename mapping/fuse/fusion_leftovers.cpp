#include "mapping/fuse/fusion_leftovers.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

namespace cloister {
namespace {

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

/// The occupied voxels of a volume that a surface needs (see forget_wall_interiors).
class SurfaceVoxels {
 public:
  SurfaceVoxels(const VoxelStore& store, const Volume& volume) {
    volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
      const BlockBits occupied = bits_where(view, [](LogOdds value) { return value > 0; });
      if (occupied.any()) solids_.push_back({coord, occupied, free_bits(view), {}, {}, {}});
    });
    std::unordered_map<BlockCoord, const Solid*, CoordHash> index;
    index.reserve(solids_.size());
    for (const Solid& solid : solids_) index.emplace(solid.coord, &solid);
    for (Solid& solid : solids_) {
      const Halo free = halo_of([&](std::size_t k) {
        const BlockCoord coord = solid.coord + offset(k);
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
  static constexpr std::size_t kAround = 27;
  static BlockCoord offset(std::size_t k) {
    const int i = static_cast<int>(k);
    return {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
  }

  /// A block with occupied voxels.
  struct Solid {
    BlockCoord coord;
    BlockBits occupied;       ///< at the end, only those that are needed
    BlockBits free;
    BlockBits front;          ///< those with a face in common with free space
    BlockBits touching_free;  ///< those with as much as a corner in common with it
    std::array<const Solid*, kAround> around;  ///< by offset; null where nothing is occupied
  };

  /// Voxels of a block and one more all around: row y + 1 of slice z + 1 has the voxel at x in bit x + 1.
  struct Halo {
    unsigned row[kBlockEdge + 2][kBlockEdge + 2];
  };

  template <typename BitsAt>
  static Halo halo_of(BitsAt&& bits_at) {
    std::array<BlockBits, kAround> around;
    for (std::size_t k = 0; k < kAround; ++k) around[k] = bits_at(k);
    Halo halo;
    for (int z = -1; z <= kBlockEdge; ++z) {
      for (int y = -1; y <= kBlockEdge; ++y) {
        const int first = 3 * ((y >> kBlockShift) + 1) + 9 * ((z >> kBlockShift) + 1);
        const auto row = [&](int dx) -> unsigned {
          return around[static_cast<std::size_t>(first + dx + 1)].word[z & 7] >> (kBlockEdge * (y & 7)) & 0xff;
        };
        halo.row[z + 1][y + 1] = row(-1) >> 7 | row(0) << 1 | (row(1) & 1) << (kBlockEdge + 1);
      }
    }
    return halo;
  }

  /// The voxels of a block for which `row_at(y + 1, z + 1)` has bit x + 1.
  template <typename RowAt>
  static BlockBits bits_of_rows(RowAt&& row_at) {
    BlockBits bits{};
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y)
        bits.word[z] |= std::uint64_t{row_at(y + 1, z + 1) >> 1 & 0xff} << (kBlockEdge * y);
    }
    return bits;
  }

  /// Voxels with a face in common with those of a halo.
  static BlockBits beside(const Halo& halo) {
    return bits_of_rows([&](int y, int z) {
      return halo.row[z][y] << 1 | halo.row[z][y] >> 1 | halo.row[z][y - 1] | halo.row[z][y + 1] |
             halo.row[z - 1][y] | halo.row[z + 1][y];
    });
  }

  /// Those of a halo, and voxels with a face, an edge or a corner in common with them.
  static BlockBits touching(const Halo& halo) {
    return bits_of_rows([&](int y, int z) {
      unsigned row = 0;
      for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) row |= halo.row[z + dz][y + dy];
      }
      return row << 1 | row | row >> 1;
    });
  }

  static BlockBits both(const BlockBits& a, const BlockBits& b) {
    BlockBits bits;
    for (int z = 0; z < kBlockEdge; ++z) bits.word[z] = a.word[z] & b.word[z];
    return bits;
  }

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
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, coord, &chunk);  // is there: it is known
    // A coarse node takes no memory: it stays.
    if (!Volume::has_block(*place)) return;
    Block& block = pools.store.block(Volume::block_index(*place));
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (block.voxels[i] > 0 && (needed.word[i >> 6] >> (i & 63) & 1) == 0)
        block.voxels[i] = kUnknownLogOdds;
    }
    (void)volume.settle_block(pools, *chunk, *place);
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
    std::array<int, 8> num_free{};
    for (int i = 0; i < kBlockVoxels; ++i)
      num_free[static_cast<std::size_t>(octant_of(i))] += block.voxels[i] < 0;
    unsigned free = 0;
    LogOdds weakest = std::numeric_limits<LogOdds>::min();
    for (int octant = 0; octant < 8; ++octant)
      free |= static_cast<unsigned>(num_free[static_cast<std::size_t>(octant)] >=
                                    kOctantVoxels - kMaxUnseenVoxels)
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
