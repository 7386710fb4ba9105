#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "mapping/voxel/volume.hpp"

namespace cloister {

/// What a submap holds at one block's place now.
struct BlockState {
  BlockCoord coord = BlockCoord::Zero();
  OctantMask known =
      kNoOctants;  ///< of a coarse node; none of them and no voxels: nothing is known here
  LogOdds coarse = kUnknownLogOdds;  ///< of a coarse node's known octants
  std::vector<LogOdds> voxels;       ///< 512, x fastest, or none
};

/// What has changed in a submap since somebody looked.
struct BlockDelta {
  std::uint64_t since = 0;  ///< what it builds on; 0: what was known before is to be forgotten
  std::uint64_t up_to = 0;  ///< what to ask from next
  bool is_last = true;      ///< nothing newer is left
  std::vector<BlockState> blocks;
};

/// Tells which blocks of one submap have changed, by a hash of each: who has the state of one moment can be brought to
/// the present one block by block, and no more than changed travels.
///
/// Each change gets the next number. A block that changes again moves to the end, so that however often one asks, every
/// block comes at most once a change, and the oldest first.
///
/// Threads: one at a time. Allocates some 100 bytes a block. `update` reads the whole volume: 1 ms for 10 MB.
class BlockChanges {
 public:
  /// @param first  numbers begin behind it; another one for every map, so that numbers of one mean nothing to the next
  explicit BlockChanges(std::uint64_t first) : first_(first), newest_(first) {}

  /// Looks at the volume as it is.
  void update(const VoxelStore& store, const Volume& volume);

  /// What has changed after `since`, as far as the last update saw. A block that has changed again is given as it is
  /// now, and once more after the next update.
  /// @param since  `up_to` of the last answer; one that is none of this map's begins anew, as 0 does
  [[nodiscard]] BlockDelta since(const VoxelStore& store, const Volume& volume, std::uint64_t since,
                                 std::size_t max_blocks) const;

 private:
  struct Entry {
    std::uint64_t hash = 0;  ///< 0: nothing is known there any more
    std::uint64_t change = 0;
    std::uint64_t seen = 0;
  };
  struct CoordHash {
    std::size_t operator()(const BlockCoord& coord) const;
  };

  void note(const BlockCoord& coord, Entry& entry, std::uint64_t hash);

  std::uint64_t first_;
  std::uint64_t newest_;
  std::uint64_t num_updates_ = 0;
  std::unordered_map<BlockCoord, Entry, CoordHash> entries_;
  std::map<std::uint64_t, BlockCoord> by_change_;
};

}  // namespace cloister
