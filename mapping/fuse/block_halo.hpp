#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What lies next to what, for all voxels of a block at once. Bits are those of BlockBits. No allocation.

struct BlockCoordHash {
  std::size_t operator()(const BlockCoord& c) const {
    return static_cast<std::size_t>(c.x()) * 73856093u ^ static_cast<std::size_t>(c.y()) * 19349663u ^
           static_cast<std::size_t>(c.z()) * 83492791u;
  }
};

/// The voxels of a block that satisfy a condition on their value.
template <typename Condition>
[[nodiscard]] BlockBits bits_where(const BlockView& view, Condition&& holds) {
  BlockBits bits{};
  if (view.block == nullptr) {
    if (!holds(view.coarse)) return bits;
    for (int octant = 0; octant < 8; ++octant) {
      if ((view.known >> octant & 1) == 0) continue;
      for (int z = 0; z < kOctantEdge; ++z) bits.word[octant_corner(octant).z() + z] |= octant_rows(octant);
    }
    return bits;
  }
  for (int i = 0; i < kBlockVoxels; ++i)
    bits.word[i >> 6] |= std::uint64_t{holds(view.block->voxels[i])} << (i & 63);
  return bits;
}
[[nodiscard]] inline BlockBits free_bits(const BlockView& view) {
  return bits_where(view, [](LogOdds value) { return value < 0; });
}
[[nodiscard]] inline BlockBits occupied_bits(const BlockView& view) {
  return bits_where(view, [](LogOdds value) { return value > 0; });
}
[[nodiscard]] inline BlockBits both(const BlockBits& a, const BlockBits& b) {
  BlockBits bits;
  for (int z = 0; z < kBlockEdge; ++z) bits.word[z] = a.word[z] & b.word[z];
  return bits;
}
/// Those of a that are not of b.
[[nodiscard]] inline BlockBits without(const BlockBits& a, const BlockBits& b) {
  BlockBits bits;
  for (int z = 0; z < kBlockEdge; ++z) bits.word[z] = a.word[z] & ~b.word[z];
  return bits;
}

[[nodiscard]] inline int count_of(const BlockBits& bits) {
  int count = 0;
  for (const std::uint64_t word : bits.word) count += std::popcount(word);
  return count;
}

/// A block and the 26 around it, by number.
inline constexpr std::size_t kBlocksAround = 27;
[[nodiscard]] inline BlockCoord offset_around(std::size_t k) {
  const int i = static_cast<int>(k);
  return {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
}

/// Voxels of a block and one more all around: row y + 1 of slice z + 1 has the voxel at x in bit x + 1.
struct Halo {
  unsigned row[kBlockEdge + 2][kBlockEdge + 2];
};

/// @param bits_at  BlockBits of a block by its number around
template <typename BitsAt>
[[nodiscard]] Halo halo_of(BitsAt&& bits_at) {
  std::array<BlockBits, kBlocksAround> around;
  for (std::size_t k = 0; k < kBlocksAround; ++k) around[k] = bits_at(k);
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
[[nodiscard]] BlockBits bits_of_rows(RowAt&& row_at) {
  BlockBits bits{};
  for (int z = 0; z < kBlockEdge; ++z) {
    for (int y = 0; y < kBlockEdge; ++y)
      bits.word[z] |= std::uint64_t{row_at(y + 1, z + 1) >> 1 & 0xff} << (kBlockEdge * y);
  }
  return bits;
}
/// Voxels with a face in common with those of a halo.
[[nodiscard]] inline BlockBits beside(const Halo& halo) {
  return bits_of_rows([&](int y, int z) {
    return halo.row[z][y] << 1 | halo.row[z][y] >> 1 | halo.row[z][y - 1] | halo.row[z][y + 1] |
           halo.row[z - 1][y] | halo.row[z + 1][y];
  });
}
/// Those of a halo, and voxels with a face, an edge or a corner in common with them.
[[nodiscard]] inline BlockBits touching(const Halo& halo) {
  return bits_of_rows([&](int y, int z) {
    unsigned row = 0;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) row |= halo.row[z + dz][y + dy];
    }
    return row << 1 | row | row >> 1;
  });
}

}  // namespace cloister
