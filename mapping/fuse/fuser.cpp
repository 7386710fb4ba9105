#include "mapping/fuse/fuser.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/fuse/block_sampler.hpp"
#include "mapping/integrate/evidence.hpp"

namespace cloister {
namespace {

bool precedes(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

void sort_unique(std::vector<Eigen::Vector3i>& coords) {
  std::sort(coords.begin(), coords.end(), precedes);
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
}

/// Blocks of `into` that something known in `from` reaches, in a fixed order.
std::vector<BlockCoord> blocks_reached(const VoxelStore& store, const Volume& from,
                                       const Pose& T_into_from, double voxel_size_m) {
  std::vector<BlockCoord> reached;
  // Neighbours reach much the same blocks: sorting now and then keeps the list a few times as long as the answer.
  std::size_t sort_at = 1 << 16;
  from.for_each_block(store, [&](const BlockCoord& coord, const BlockView&) {
    if (reached.size() > sort_at) {
      sort_unique(reached);
      sort_at = std::max(sort_at, 2 * reached.size());
    }
    const BlockRange range = blocks_under(coord, T_into_from, voxel_size_m);
    for (int z = range.low.z(); z <= range.high.z(); ++z) {
      for (int y = range.low.y(); y <= range.high.y(); ++y) {
        for (int x = range.low.x(); x <= range.high.x(); ++x) reached.push_back({x, y, z});
      }
    }
  });
  sort_unique(reached);
  return reached;
}

/// An upper bound of what the fusion takes from the pools, against what they have.
bool has_room(const std::vector<BlockCoord>& reached, const VoxelPools& pools, const Volume& into,
              BlockSampler& sampler) {
  std::size_t new_blocks = 0;
  std::vector<ChunkCoord> new_chunks;
  for (const BlockCoord& coord : reached) {
    const std::optional<LogOdds> under = sampler.gather(coord);
    if (under && *under == kUnknownLogOdds) continue;
    if (into.find_chunk(pools.store, parent_coord(coord)) == kNoIndex)
      new_chunks.push_back(parent_coord(coord));
    new_blocks += !under && into.view(pools.store, coord).block == nullptr;
  }
  sort_unique(new_chunks);
  return new_blocks <= pools.blocks.num_free() && new_chunks.size() <= pools.chunks.num_free();
}

}  // namespace

bool fuse_volume(const Volume& from, const Pose& T_from_into, const VoxelConfig& config,
                 VoxelPools& pools, Volume& into, BothKnown rule) {
  const int lowest = log_odds_steps(config.log_odds_min);
  const int highest = log_odds_steps(config.log_odds_max);
  const std::vector<BlockCoord> reached =
      blocks_reached(pools.store, from, T_from_into.inverse(), config.voxel_size_m);
  BlockSampler sampler(pools.store, from, T_from_into, config.voxel_size_m, -lowest);
  if (!has_room(reached, pools, into, sampler)) return false;
  const bool grids_agree = sampler.grids_agree();

  for (const BlockCoord& coord : reached) {
    const std::optional<LogOdds> under = sampler.gather(coord);
    if (under && *under == kUnknownLogOdds) continue;
    Chunk* chunk = nullptr;
    std::uint32_t* place = into.make_place(pools, coord, &chunk);
    const bool is_complete =
        !Volume::has_block(*place) && Volume::known_octants(*place) == kAllOctants;
    if (is_complete && rule == BothKnown::kKeep) continue;
    if (under && !Volume::has_block(*place)) {
      const LogOdds before = Volume::coarse_value(*place);
      const LogOdds sum = add_log_odds(before, *under, lowest, highest);
      const bool is_partial =
          before != kUnknownLogOdds && Volume::known_octants(*place) != kAllOctants;
      // One value stands for all octants: where only some were known, the weaker of what both kinds come to.
      if (!is_partial || (before < 0 && *under < 0)) {
        into.set_coarse(pools, *chunk, *place, is_partial ? std::max(sum, *under) : sum,
                        kAllOctants);
        continue;
      }
    }
    Block* block = into.make_block(pools, *chunk, *place);
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y) {
        for (int x = 0; x < kBlockEdge; ++x) {
          LogOdds evidence = under ? *under : sampler.at(x, y, z);
          LogOdds& voxel = block->voxels[index_in_block(x, y, z)];
          if (evidence == kUnknownLogOdds) continue;
          if (rule == BothKnown::kKeep && voxel != kUnknownLogOdds) continue;
          // A surface lies anywhere in its voxel, so the nearest voxel of the other grid can be the next one to it: taken
          // as it is, every fusion would thicken surfaces here and wear them away there.
          if (voxel != kUnknownLogOdds && !grids_agree) {
            evidence = sampler.weighed_at(x, y, z);
            if (evidence == kUnknownLogOdds) continue;
          }
          voxel = add_log_odds(voxel, evidence, lowest, highest);
        }
      }
    }
    into.settle_block(pools, *chunk, *place);
  }
  return true;
}

}  // namespace cloister
