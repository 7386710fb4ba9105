#include "mapping/fuse/place_sharing.hpp"

#include <algorithm>
#include <unordered_set>
#include <vector>

#include "mapping/fuse/block_halo.hpp"
#include "mapping/fuse/fuser.hpp"
#include "mapping/fuse/fusion_leftovers.hpp"
#include "mapping/fuse/same_surface.hpp"

namespace cloister {
namespace {

// How much of a block the other must know for it to be dropped rather than given: what it says is not filled in.
constexpr double kMinKnownToDrop = 0.6;
// How much of a block's surface the other must show: where the two may yet move against each other a floor alone, which
// they show whatever lies between them, must not take a wall along.
constexpr double kMinSameToShare = 0.5;
constexpr double kMinSameToDrop = 0.8;
// Where the other knows so many times as much of a block's place, its word stands, whatever the block says: with full trust
// blocks are given instead. Where the graph is sure of the two, that is their one place, and two views of it that differ are
// one too many; where it is not, they may turn out to be of two places.
double min_ratio_to_drop(SharingTrust trust) {
  return trust == SharingTrust::kContradicted ? 1.0 : 1.5;
}

// A chunk that holds fewer places than this is a glimpse, and its index takes more than what it holds.
constexpr std::uint32_t kMinPlacesInChunk = 8;

// Of a wall that two grids cut differently, a sliver has fewer voxels than three quarters of one layer, and nearly all that
// is seen of it must be shown by the other.
constexpr int kMaxSliverVoxels = kBlockEdge * kBlockEdge * 3 / 4;
constexpr double kMinShownOfSliver = 0.9;

bool is_glimpsed(const VoxelStore& store, const Volume& volume, const BlockCoord& coord) {
  const PoolIndex chunk = volume.find_chunk(store, parent_coord(coord));
  return chunk == kNoIndex || store.chunk(chunk).num_known < kMinPlacesInChunk;
}

/// Blocks of `from` for which `into` is the better home.
struct Leaving {
  std::vector<BlockCoord> given;    ///< fill in what `into` does not know
  std::vector<BlockCoord> dropped;  ///< `into` says it all, if a little aside
  /// Walls that lose the free space before them: given as well, for without it they are no surface.
  std::vector<BlockCoord> copied;
};

/// The blocks that stay in `from` though the free space before most of their surface leaves, if `into` does not show it anyway.
std::vector<BlockCoord> find_walls_left(const VoxelStore& store, const Volume& from, const Volume& into,
                                        const Eigen::Isometry3f& T_into_from, float voxel_m, const Leaving& leaving) {
  std::unordered_set<BlockCoord, BlockCoordHash> gone(leaving.given.begin(), leaving.given.end());
  gone.insert(leaving.dropped.begin(), leaving.dropped.end());
  std::unordered_set<BlockCoord, BlockCoordHash> asked;
  std::vector<BlockCoord> walls;
  const auto ask = [&](const BlockCoord& coord) {
    if (gone.contains(coord) || !asked.insert(coord).second) return;
    const BlockView view = from.view(store, coord);
    if (view.block == nullptr) return;
    const BlockBits occupied = occupied_bits(view);
    const auto surface_beside = [&](bool is_gone) {
      return both(occupied, touching(halo_of([&](std::size_t k) {
                    const BlockCoord neighbour = coord + offset_around(k);
                    return gone.contains(neighbour) == is_gone ? free_bits(from.view(store, neighbour)) : BlockBits{};
                  })));
    };
    const BlockBits kept = surface_beside(false);
    if (count_of(without(surface_beside(true), kept)) <= count_of(kept)) return;
    if (compare_block(store, coord, view, from, into, T_into_from, voxel_m).share_same < kMinSameToDrop)
      walls.push_back(coord);
  };
  for (const auto* coords : {&leaving.given, &leaving.dropped}) {
    for (const BlockCoord& coord : *coords) {
      for (std::size_t k = 0; k < kBlocksAround; ++k) ask(coord + offset_around(k));
    }
  }
  return walls;
}

Leaving find_leaving(const VoxelStore& store, const Submap& from, const Submap& into,
                     const Pose& T_into_from, double edge_m, SharingTrust trust) {
  Leaving leaving;
  const Eigen::Isometry3f T = T_into_from.cast<float>();
  const auto block_m = static_cast<float>(edge_m);
  from.volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    const Eigen::Vector3f middle_from = (coord.cast<float>().array() + 0.5f).matrix() * block_m;
    const Eigen::Vector3f middle_into = T * middle_from;
    const BlockCoord coord_into = (middle_into / block_m).array().floor().matrix().cast<int>();
    const auto compare = [&] {
      return compare_block(store, coord, view, from.volume, into.volume, T, block_m / kBlockEdge);
    };
    if (trust == SharingTrust::kFull && is_glimpsed(store, from.volume, coord) &&
        !is_glimpsed(store, into.volume, coord_into)) {
      const BlockAgreement agreement = compare();
      if (agreement.share_same >= kMinSameToDrop) {
        const bool is_copy = agreement.share_known >= kMinKnownToDrop;
        (is_copy ? leaving.dropped : leaving.given).push_back(coord);
        return;
      }
    }
    const double ratio = known_ratio(store, view, into.volume, middle_into, block_m);
    if (ratio < kMinKnownRatio) return;
    if (into.path.squared_distance(middle_into) >= from.path.squared_distance(middle_from)) return;
    if (trust != SharingTrust::kFull && ratio >= min_ratio_to_drop(trust)) {
      leaving.dropped.push_back(coord);
      return;
    }
    const BlockAgreement agreement = compare();
    const bool is_copy = agreement.share_known >= kMinKnownToDrop;
    if (trust == SharingTrust::kFull) {
      if (agreement.share_same < kMinSameToShare) return;
      (is_copy && !agreement.is_aligned ? leaving.dropped : leaving.given).push_back(coord);
    } else if (agreement.share_same >= kMinSameToDrop && is_copy &&
               (trust == SharingTrust::kUncertain || agreement.is_aligned)) {
      leaving.dropped.push_back(coord);
    }
  });
  if (trust == SharingTrust::kFull) {
    leaving.copied = find_walls_left(store, from.volume, into.volume, T, block_m / kBlockEdge, leaving);
  }
  return leaving;
}

/// Moves places between volumes of one frame, as far as the pool of chunks goes.
std::size_t move_places(const std::vector<BlockCoord>& coords, VoxelPools& pools, Volume& from,
                        Volume& to) {
  std::size_t moved = 0;
  for (const BlockCoord& coord : coords) {
    Chunk* chunk_to = nullptr;
    std::uint32_t* place_to = to.make_place(pools, coord, &chunk_to);
    if (place_to == nullptr) break;
    Chunk* chunk_from = nullptr;
    std::uint32_t* place_from =
        from.make_place(pools, coord, &chunk_from);  // is there: it is known
    if (Volume::has_block(*place_from)) {
      to.attach_block(*chunk_to, *place_to, from.detach_block(*chunk_from, *place_from));
    } else {
      to.set_coarse(pools, *chunk_to, *place_to, Volume::coarse_value(*place_from),
                    Volume::known_octants(*place_from));
      from.set_coarse(pools, *chunk_from, *place_from, kUnknownLogOdds, kNoOctants);
    }
    ++moved;
  }
  return moved;
}

/// Copies blocks between volumes of one frame, as far as the pools go.
std::size_t copy_blocks(const std::vector<BlockCoord>& coords, VoxelPools& pools, const Volume& from, Volume& to) {
  std::size_t copied = 0;
  for (const BlockCoord& coord : coords) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = to.make_place(pools, coord, &chunk);
    Block* block = place == nullptr ? nullptr : to.make_block(pools, *chunk, *place);
    if (block == nullptr) break;
    *block = *from.view(pools.store, coord).block;
    ++copied;
  }
  return copied;
}

std::optional<std::size_t> give(Submap& from, Submap& into, const Pose& T_into_from,
                                const VoxelConfig& config, VoxelPools& pools, SharingTrust trust) {
  const auto [given, dropped, copied] =
      find_leaving(pools.store, from, into, T_into_from, config.voxel_size_m * kBlockEdge, trust);
  if (given.empty() && dropped.empty()) return 0;
  Volume parcel;
  const std::size_t num_given = move_places(given, pools, from.volume, parcel);
  if (num_given < given.size() || copy_blocks(copied, pools, from.volume, parcel) < copied.size() ||
      !fuse_volume(parcel, T_into_from.inverse(), config, pools, into.volume, BothKnown::kKeep)) {
    // Back where it came from: the chunks are still there.
    (void)move_places({given.begin(), given.begin() + static_cast<std::ptrdiff_t>(num_given)},
                      pools, parcel, from.volume);
    parcel.clear(pools);
    return std::nullopt;
  }
  parcel.clear(pools);
  const std::size_t num_dropped = move_places(dropped, pools, from.volume, parcel);
  parcel.clear(pools);
  from.volume.release_empty_chunks(pools);
  return num_given + num_dropped;
}

/// True when an octant would be taken for free as a whole, were it not for its occupied voxels.
bool becomes_free(const BlockView& view) {
  unsigned occupied = 0;
  for (int i = 0; i < kBlockVoxels; ++i) occupied |= static_cast<unsigned>(view.at(i) > 0) << octant_of(i);
  return (occupied & octants_seen_free(view)) != 0;
}

/// @return number of blocks that lost their occupied voxels: the caller may have their free space made coarse
std::size_t forget_slivers(Submap& of, const Submap& shown_by, const Pose& T_shown_of, const VoxelConfig& config,
                           VoxelPools& pools) {
  const Eigen::Isometry3f T = T_shown_of.cast<float>();
  std::vector<BlockCoord> slivers;
  of.volume.for_each_block(pools.store, [&](const BlockCoord& coord, const BlockView& view) {
    if (view.block == nullptr) return;
    const int num_occupied = count_of(occupied_bits(view));
    if (num_occupied == 0 || num_occupied >= kMaxSliverVoxels) return;
    if (becomes_free(view)) return;
    if (share_shown(pools.store, coord, view, of.volume, shown_by.volume, T,
                    static_cast<float>(config.voxel_size_m)) >= kMinShownOfSliver)
      slivers.push_back(coord);
  });
  for (const BlockCoord& coord : slivers) forget_occupied(pools, of.volume, coord, {});
  if (!slivers.empty()) of.volume.release_empty_chunks(pools);
  return slivers.size();
}

}  // namespace

std::optional<std::size_t> share_places(Submap& a, Submap& b, const Pose& T_a_b,
                                        const VoxelConfig& config, VoxelPools& pools,
                                        SharingTrust trust) {
  const auto from_a = give(a, b, T_a_b.inverse(), config, pools, trust);
  if (!from_a) return std::nullopt;
  const auto from_b = give(b, a, T_a_b, config, pools, trust);
  if (!from_b) return std::nullopt;
  if (trust != SharingTrust::kFull) return *from_a + *from_b;
  const std::size_t slivers_of_a = forget_slivers(a, b, T_a_b.inverse(), config, pools);
  const std::size_t slivers_of_b = forget_slivers(b, a, T_a_b, config, pools);
  return *from_a + *from_b + slivers_of_a + slivers_of_b;
}

}  // namespace cloister
