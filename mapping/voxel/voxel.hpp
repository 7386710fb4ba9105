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

inline constexpr int kBlockEdge = 8;      ///< voxels
inline constexpr int kBlockShift = 3;
inline constexpr int kBlockVoxels = 512;
inline constexpr int kChunkEdge = 8;      ///< blocks
inline constexpr int kChunkBlocks = 512;

/// The finest node: 8x8x8 voxels, x fastest, then y, then z. Aligned for the widest vectors.
struct alignas(64) Block {
  LogOdds voxels[kBlockVoxels];
};
static_assert(sizeof(Block) == 512);

[[nodiscard]] constexpr int index_in_block(int x, int y, int z) {
  return (x & 7) | ((y & 7) << 3) | ((z & 7) << 6);
}
[[nodiscard]] inline int index_in_block(const VoxelCoord& v) { return index_in_block(v.x(), v.y(), v.z()); }

/// Block of a voxel, or chunk of a block.
[[nodiscard]] inline Eigen::Vector3i parent_coord(const Eigen::Vector3i& c) {
  return {c.x() >> kBlockShift, c.y() >> kBlockShift, c.z() >> kBlockShift};
}

/// What a block's place in a submap holds: nothing, one value for all 512 voxels (a coarse node), or a Block.
struct BlockView {
  const Block* block = nullptr;  ///< the voxels, or null when all 512 are `uniform`
  LogOdds uniform = kUnknownLogOdds;

  [[nodiscard]] bool is_unknown() const { return block == nullptr && uniform == kUnknownLogOdds; }
  [[nodiscard]] LogOdds at(int index) const { return block != nullptr ? block->voxels[index] : uniform; }
};

}  // namespace cloister
