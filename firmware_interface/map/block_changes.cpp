#include "firmware_interface/map/block_changes.hpp"

#include <xxhash.h>

#include <algorithm>

namespace cloister {
namespace {

/// Never 0.
std::uint64_t hash_of(const BlockView& view) {
  if (view.block != nullptr) return XXH3_64bits(view.block->voxels, sizeof(view.block->voxels)) | 1;
  return std::uint64_t{view.known} << 16 |
         static_cast<std::uint64_t>(static_cast<std::uint8_t>(view.coarse)) << 8 | 2;
}

}  // namespace

std::size_t BlockChanges::CoordHash::operator()(const BlockCoord& coord) const {
  return static_cast<std::size_t>(XXH3_64bits(coord.data(), 3 * sizeof(int)));
}

void BlockChanges::note(const BlockCoord& coord, Entry& entry, std::uint64_t hash) {
  entry.seen = num_updates_;
  if (entry.hash == hash) return;
  if (entry.change != 0) by_change_.erase(entry.change);
  entry.hash = hash;
  entry.change = ++newest_;
  by_change_.emplace(entry.change, coord);
}

void BlockChanges::update(const VoxelStore& store, const Volume& volume) {
  ++num_updates_;
  volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    note(coord, entries_[coord], hash_of(view));
  });
  for (auto& [coord, entry] : entries_) {
    if (entry.seen != num_updates_) note(coord, entry, 0);
  }
}

BlockDelta BlockChanges::since(const VoxelStore& store, const Volume& volume, std::uint64_t since,
                               std::size_t max_blocks) const {
  BlockDelta delta;
  const bool is_ours = since > first_ && since <= newest_;
  delta.since = is_ours ? since : 0;
  delta.up_to = is_ours ? since : first_;
  auto next = by_change_.upper_bound(delta.up_to);
  for (; next != by_change_.end() && delta.blocks.size() < max_blocks; ++next) {
    BlockState& block = delta.blocks.emplace_back();
    block.coord = next->second;
    const BlockView view = volume.view(store, block.coord);
    if (view.block != nullptr) {
      block.voxels.assign(view.block->voxels, view.block->voxels + kBlockVoxels);
    } else {
      block.known = view.known;
      block.coarse = view.coarse;
    }
    delta.up_to = next->first;
  }
  delta.is_last = next == by_change_.end();
  return delta;
}

}  // namespace cloister
