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

/// Layers of occupied voxels behind the free space of a volume.
class WallLayers {
 public:
  WallLayers(const VoxelStore& store, const Volume& volume) : store_(store), volume_(volume) {
    volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
      const BlockBits occupied = bits_where(view, [](LogOdds value) { return value > 0; });
      if (occupied.any()) solids_.push_back({coord, occupied, free_bits(view), {}, {}});
    });
    std::unordered_map<BlockCoord, std::int32_t, CoordHash> index;
    index.reserve(solids_.size());
    for (std::size_t i = 0; i < solids_.size(); ++i)
      index.emplace(solids_[i].coord, static_cast<std::int32_t>(i));
    for (Solid& solid : solids_) {
      for (int k = 0; k < kAround; ++k) {
        const auto found = index.find(solid.coord + offset(k));
        solid.around[static_cast<std::size_t>(k)] = found == index.end() ? -1 : found->second;
      }
    }
    next_.resize(solids_.size());
    // What is next to free space, and whatever touches that: all corners of the cubes through which a surface passes, and
    // what says how thick it is there (see extract_mesh).
    (void)find_next(&WallLayers::beside_free, Kept::kYes);
    (void)find_next(&WallLayers::touching, Kept::kYes);
    while (find_next(&WallLayers::beside, Kept::kNo)) {
    }
  }

  /// Calls `visit(BlockCoord, BlockBits)` for every block with voxels behind the first two layers, and connected to them.
  template <typename Visitor>
  void for_each_interior(Visitor&& visit) const {
    for (const Solid& solid : solids_) {
      if (solid.interior.any()) visit(solid.coord, solid.interior);
    }
  }

 private:
  static constexpr int kAround = 27, kSelf = 13;

  /// A block with occupied voxels.
  struct Solid {
    BlockCoord coord;
    BlockBits occupied;  ///< that no layer has reached yet
    BlockBits layer;     ///< what was found last; at the beginning, free space
    BlockBits interior;  ///< the rest of what was occupied
    std::array<std::int32_t, kAround> around;  ///< indices of solid blocks by offset, or -1
  };

  static constexpr int index_of(int dx, int dy, int dz) { return kSelf + dx + 3 * dy + 9 * dz; }
  static BlockCoord offset(int k) { return {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1}; }

  /// A block's last layer and a voxel of what is around it: row y + 1 of slice z + 1 has the voxel at x in bit x + 1.
  struct Halo {
    unsigned row[kBlockEdge + 2][kBlockEdge + 2];
  };

  template <typename LayerAt>
  static Halo halo_of(LayerAt&& layer_at) {
    Halo halo;
    for (int z = -1; z <= kBlockEdge; ++z) {
      for (int y = -1; y <= kBlockEdge; ++y) {
        const auto row = [&](int dx) -> unsigned {
          const BlockBits* layer = layer_at(index_of(dx, y >> kBlockShift, z >> kBlockShift));
          if (layer == nullptr) return 0;
          return layer->word[z & 7] >> (kBlockEdge * (y & 7)) & 0xff;
        };
        halo.row[z + 1][y + 1] = row(-1) >> 7 | row(0) << 1 | (row(1) & 1) << (kBlockEdge + 1);
      }
    }
    return halo;
  }

  [[nodiscard]] Halo halo_of(const Solid& solid) const {
    return halo_of([&](int k) {
      const std::int32_t at = solid.around[static_cast<std::size_t>(k)];
      return at < 0 ? nullptr : &solids_[static_cast<std::size_t>(at)].layer;
    });
  }

  /// Voxels with a face in common with those of a halo.
  static BlockBits sides_of(const Halo& halo) {
    BlockBits bits{};
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y) {
        const auto& rows = halo.row[z + 1];
        const unsigned row = rows[y + 1] << 1 | rows[y + 1] >> 1 | rows[y] | rows[y + 2] |
                             halo.row[z][y + 1] | halo.row[z + 2][y + 1];
        bits.word[z] |= std::uint64_t{row >> 1 & 0xff} << (kBlockEdge * y);
      }
    }
    return bits;
  }

  [[nodiscard]] BlockBits beside(const Solid& solid) const { return sides_of(halo_of(solid)); }

  [[nodiscard]] BlockBits beside_free(const Solid& solid) const {
    std::array<BlockBits, kAround> free{};
    for (const int k : {index_of(-1, 0, 0), index_of(1, 0, 0), index_of(0, -1, 0),
                        index_of(0, 1, 0), index_of(0, 0, -1), index_of(0, 0, 1)}) {
      free[static_cast<std::size_t>(k)] = free_bits(volume_.view(store_, solid.coord + offset(k)));
    }
    free[kSelf] = solid.layer;
    return sides_of(halo_of([&](int k) { return &free[static_cast<std::size_t>(k)]; }));
  }

  /// Voxels with a face, an edge or a corner in common with the last layer.
  [[nodiscard]] BlockBits touching(const Solid& solid) const {
    const Halo halo = halo_of(solid);
    BlockBits bits{};
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y) {
        unsigned row = 0;
        for (int dz = 0; dz < 3; ++dz) {
          for (int dy = 0; dy < 3; ++dy) row |= halo.row[z + dz][y + dy];
        }
        bits.word[z] |= std::uint64_t{(row << 1 | row | row >> 1) >> 1 & 0xff} << (kBlockEdge * y);
      }
    }
    return bits;
  }

  enum class Kept { kYes, kNo };

  /// The occupied voxels that the last layer reaches become the next one. @return false when there are none
  bool find_next(BlockBits (WallLayers::*reached_from)(const Solid&) const, Kept kept) {
    bool is_any = false;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      next_[i] = (this->*reached_from)(solids_[i]);
      for (int z = 0; z < kBlockEdge; ++z) next_[i].word[z] &= solids_[i].occupied.word[z];
      is_any = is_any || next_[i].any();
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      Solid& solid = solids_[i];
      solid.layer = next_[i];
      for (int z = 0; z < kBlockEdge; ++z) {
        solid.occupied.word[z] &= ~solid.layer.word[z];
        if (kept == Kept::kNo) solid.interior.word[z] |= solid.layer.word[z];
      }
    }
    return is_any;
  }

  const VoxelStore& store_;
  const Volume& volume_;
  std::vector<Solid> solids_;
  std::vector<BlockBits> next_;
};

bool is_occupied_somewhere(const Block& block) {
  return *std::max_element(block.voxels, block.voxels + kBlockVoxels) > 0;
}

}  // namespace

std::size_t forget_wall_interiors(VoxelPools& pools, Volume& volume) {
  const std::size_t blocks_before = volume.num_blocks();
  const WallLayers layers(pools.store, volume);
  layers.for_each_interior([&](const BlockCoord& coord, const BlockBits& interior) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, coord, &chunk);  // is there: it is known
    // A coarse node takes no memory: it stays.
    if (!Volume::has_block(*place)) return;
    Block& block = pools.store.block(Volume::block_index(*place));
    for (int i = 0; i < kBlockVoxels; ++i) {
      if ((interior.word[i >> 6] >> (i & 63) & 1) != 0) block.voxels[i] = kUnknownLogOdds;
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
