#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace cloister {

/// Log-odds of one voxel in steps of kLogOddsStep: negative is free, positive is occupied, zero is unknown.
/// Evidence that cancels to exactly zero keeps the sign of the last observation with magnitude one, so a voxel that
/// was ever observed never looks unknown.
using LogOdds = std::int8_t;

inline constexpr double kLogOddsStep = 0.05;  ///< one unit of LogOdds in natural log-odds
inline constexpr LogOdds kUnknownLogOdds = 0;

/// Natural log-odds in steps, rounded to the nearest, within what a LogOdds can hold.
[[nodiscard]] inline LogOdds log_odds_steps(double natural) {
  return static_cast<LogOdds>(std::lround(std::clamp(natural / kLogOddsStep, -127.0, 127.0)));
}

enum class VoxelState : std::uint8_t { kUnknown, kFree, kOccupied };

[[nodiscard]] constexpr VoxelState state_of(LogOdds value) {
  return value == 0 ? VoxelState::kUnknown : value < 0 ? VoxelState::kFree : VoxelState::kOccupied;
}

/// A voxel is named by its integer coordinate v in its submap's grid; it covers [v, v + 1) * voxel_size in S and its
/// centre is (v + 0.5) * voxel_size. Blocks are 8x8x8 voxels, chunks are 8x8x8 blocks; their coordinates are those of
/// their lowest voxel divided by the edge, rounded down.
using VoxelCoord = Eigen::Vector3i;
using BlockCoord = Eigen::Vector3i;
using ChunkCoord = Eigen::Vector3i;

inline constexpr int kBlockEdge = 8;  ///< voxels
inline constexpr int kBlockShift = 3;
inline constexpr int kBlockVoxels = 512;
inline constexpr int kChunkEdge = 8;  ///< blocks
inline constexpr int kChunkBlocks = 512;

/// The finest node: 8x8x8 voxels, x fastest, then y, then z. Aligned for the widest vectors.
struct alignas(64) Block {
  LogOdds voxels[kBlockVoxels];
};
static_assert(sizeof(Block) == 512);

[[nodiscard]] constexpr int index_in_block(int x, int y, int z) {
  return (x & 7) | ((y & 7) << 3) | ((z & 7) << 6);
}
[[nodiscard]] inline int index_in_block(const VoxelCoord& v) {
  return index_in_block(v.x(), v.y(), v.z());
}

/// Block of a voxel, or chunk of a block.
[[nodiscard]] inline Eigen::Vector3i parent_coord(const Eigen::Vector3i& c) {
  return {c.x() >> kBlockShift, c.y() >> kBlockShift, c.z() >> kBlockShift};
}

/// Which of a block's eight octants of 4x4x4 voxels: bit x + 2 y + 4 z. 0 = none.
using OctantMask = std::uint8_t;
inline constexpr OctantMask kNoOctants = 0;
inline constexpr OctantMask kAllOctants = 0xff;
inline constexpr int kOctantEdge = 4;  ///< voxels
inline constexpr int kOctantVoxels = 64;
inline constexpr int kMaxUnseenVoxels = 16;  ///< of an octant that is free as a whole all the same

/// Octant of a voxel, by its index in the block.
[[nodiscard]] constexpr int octant_of(int index) {
  return (index >> 2 & 1) | (index >> 4 & 2) | (index >> 6 & 4);
}

/// The lowest voxel of an octant, by its coordinates in the block.
[[nodiscard]] inline VoxelCoord octant_corner(int octant) {
  return {(octant & 1) * kOctantEdge, (octant >> 1 & 1) * kOctantEdge, (octant >> 2) * kOctantEdge};
}

/// One bit for each voxel of a block: bit x + 8 y of word z.
struct BlockBits {
  std::uint64_t word[kBlockEdge];

  [[nodiscard]] bool any() const {
    std::uint64_t all = 0;
    for (const std::uint64_t w : word) all |= w;
    return all != 0;
  }
};

/// Bits of an octant's voxels in a word of BlockBits, for each z that it reaches.
[[nodiscard]] constexpr std::uint64_t octant_rows(int octant) {
  return std::uint64_t{0x0f0f0f0f}
         << ((octant & 1) * kOctantEdge + (octant >> 1 & 1) * kOctantEdge * kBlockEdge);
}

/// What a block's place in a submap holds: a Block, or a coarse node, which is one value for those of its octants that
/// are known.
struct BlockView {
  const Block* block = nullptr;  ///< the voxels, or null for a coarse node
  LogOdds coarse = kUnknownLogOdds;
  OctantMask known = kNoOctants;  ///< of a coarse node; `coarse` is 0 when there are none

  [[nodiscard]] bool is_unknown() const { return block == nullptr && known == kNoOctants; }
  /// One value for all 512 voxels?
  [[nodiscard]] bool is_uniform() const {
    return block == nullptr && (known == kNoOctants || known == kAllOctants);
  }
  [[nodiscard]] LogOdds at(int index) const {
    if (block != nullptr) return block->voxels[index];
    return (known >> octant_of(index) & 1) != 0 ? coarse : kUnknownLogOdds;
  }
};

}  // namespace cloister
