// What one scan does to one block, compiled once for each instruction set: included by the files that Highway includes
// again and again, hence no `#pragma once` but Highway's own guard.
#if defined(CLOISTER_BLOCK_UPDATE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef CLOISTER_BLOCK_UPDATE_INL_HPP
#undef CLOISTER_BLOCK_UPDATE_INL_HPP
#else
#define CLOISTER_BLOCK_UPDATE_INL_HPP
#endif

#include <bit>

#include <hwy/highway.h>

#include "mapping/integrate/evidence.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/voxel/volume.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using LogOddsTag = hn::CappedTag<LogOdds, 64>;

/// A mask of the lowest bits, one a lane.
HWY_INLINE hn::Mask<LogOddsTag> mask_of(LogOddsTag d, std::uint64_t bits) {
  return hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&bits));
}

/// What a scan has changed in a block.
struct Changes {
  int num_changed = 0;  ///< voxels with another value than before
  int num_cleared = 0;  ///< those of them that were occupied, and are less so now

  /// May the block rest? Where something may have gone, the next scan is asked.
  [[nodiscard]] bool may_rest() const { return num_changed <= 16 && num_cleared == 0; }
};

/// Greatest value of a block.
HWY_INLINE LogOdds highest_in(const Block& block) {
  const LogOddsTag d;
  auto highest = hn::Load(d, block.voxels);
  for (int i = static_cast<int>(hn::Lanes(d)); i < kBlockVoxels;
       i += static_cast<int>(hn::Lanes(d))) {
    highest = hn::Max(highest, hn::Load(d, block.voxels + i));
  }
  HWY_ALIGN LogOdds lanes[HWY_MAX_BYTES];
  hn::Store(highest, d, lanes);
  LogOdds result = lanes[0];
  for (std::size_t i = 1; i < hn::Lanes(d); ++i) result = lanes[i] > result ? lanes[i] : result;
  return result;
}

/// Octants in which some voxel is occupied.
HWY_INLINE OctantMask occupied_octants(const Block& block) {
  const LogOddsTag d;
  const auto zero = hn::Zero(d);
  unsigned octants = 0;
  for (int half = 0; half < 2; ++half) {
    // Four slices in one: bit x + 8 y of an octant's rows.
    std::uint64_t slices = 0;
    for (int z = half * kOctantEdge; z < (half + 1) * kOctantEdge; ++z) {
      for (int i = 0; i < kBlockEdge * kBlockEdge; i += static_cast<int>(hn::Lanes(d))) {
        const auto values = hn::Load(d, block.voxels + z * kBlockEdge * kBlockEdge + i);
        std::uint64_t bits = 0;
        hn::StoreMaskBits(d, values > zero, reinterpret_cast<std::uint8_t*>(&bits));
        slices |= bits << i;
      }
    }
    for (int octant = 0; octant < 4; ++octant) {
      octants |= static_cast<unsigned>((slices & octant_rows(octant)) != 0) << (octant + 4 * half);
    }
  }
  return static_cast<OctantMask>(octants);
}

/// Adds a scan's evidence to the voxels of a block; a voxel that is hit is not free. Beams that passed beside a voxel
/// (`free` without `crossed`) make it free as long as nothing says that it is occupied: they cannot clear it.
HWY_INLINE Changes add_evidence(const Evidence& evidence, const BlockBits& free,
                                const BlockBits& crossed, const BlockBits& hit, Block& block) {
  const LogOddsTag d;
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, LogOdds{1}), minus_one = hn::Set(d, LogOdds{-1});
  const auto hit_steps = hn::Set(d, evidence.hit), miss_steps = hn::Set(d, evidence.miss);
  const auto lowest = hn::Set(d, evidence.lowest), highest = hn::Set(d, evidence.highest);
  std::size_t num_changed = 0, num_cleared = 0;
  for (int z = 0; z < kBlockEdge; ++z) {
    if ((free.word[z] | hit.word[z]) == 0) continue;
    LogOdds* slice = block.voxels + z * kBlockEdge * kBlockEdge;
    for (int i = 0; i < kBlockEdge * kBlockEdge; i += static_cast<int>(hn::Lanes(d))) {
      const auto is_free = mask_of(d, free.word[z] >> i);
      const auto is_crossed = mask_of(d, crossed.word[z] >> i);
      const auto is_hit = mask_of(d, hit.word[z] >> i);
      const auto value = hn::Load(d, slice + i);
      const auto is_cleared = hn::And(is_free, hn::Or(is_crossed, hn::Not(value > zero)));
      const auto steps =
          hn::IfThenElse(is_hit, hit_steps, hn::IfThenElseZero(is_cleared, miss_steps));
      const auto sum = hn::Min(hn::Max(hn::SaturatedAdd(value, steps), lowest), highest);
      // What cancels exactly keeps the sign of the new evidence.
      const auto sign = hn::IfThenElse(is_hit, one, hn::IfThenElseZero(is_cleared, minus_one));
      const auto updated = hn::IfThenElse(sum == zero, sign, sum);
      num_changed += hn::CountTrue(d, updated != value);
      num_cleared += hn::CountTrue(d, hn::And(is_cleared, value > zero));
      hn::Store(updated, d, slice + i);
    }
  }
  return {static_cast<int>(num_changed), static_cast<int>(num_cleared)};
}

/// Adds free octants to a place that is unknown or a free coarse node. Octants that were known become more free when at
/// least half of them was seen again; with new ones, all have the weaker value.
/// @param num_free  voxels that were seen
HWY_INLINE void add_free_octants(const Evidence& evidence, OctantMask free, int num_free,
                                 VoxelPools& pools, Volume& volume, Chunk& chunk,
                                 std::uint32_t& place) {
  const LogOdds value = Volume::coarse_value(place);
  const OctantMask known = Volume::known_octants(place);
  if ((free & ~known) != 0) {
    const LogOdds weakest = known != kNoOctants && value > evidence.miss ? value : evidence.miss;
    volume.set_coarse(pools, chunk, place, weakest, known | free);
  } else if (value != evidence.lowest && 2 * num_free >= std::popcount(known) * kOctantVoxels) {
    volume.set_coarse(pools, chunk, place,
                      add_log_odds(value, evidence.miss, evidence.lowest, evidence.highest), known);
  }
}

/// Applies what one scan says about one block. Free space stays coarse: a block without hits that is free or unknown in
/// each octant is a coarse node, and becomes one again as soon as it is. A coarse node without hits is split only by free
/// voxels of octants that are not known yet.
/// @param free  without the voxels that were hit
/// @return number of voxels that a full pool declined
HWY_INLINE std::size_t apply_to_place(const Evidence& evidence, const BlockBits& free,
                                      const BlockBits& crossed, const BlockBits& hit,
                                      VoxelPools& pools, Volume& volume, Chunk& chunk,
                                      std::uint32_t& place) {
  int num_free = 0;
  for (const std::uint64_t word : free.word) num_free += std::popcount(word);
  const bool has_hits = hit.any();
  if (!has_hits && num_free == 0) return 0;
  if (!has_hits && !Volume::has_block(place) && Volume::coarse_value(place) <= 0) {
    // An octant's rows in one word; all of them, and any.
    unsigned all = 0, any = 0;
    for (int octant = 0; octant < 8; ++octant) {
      const std::uint64_t rows = octant_rows(octant);
      std::uint64_t in_all = rows, in_any = 0;
      for (int z = 0; z < kOctantEdge; ++z) {
        in_all &= free.word[(octant >> 2) * kOctantEdge + z];
        in_any |= free.word[(octant >> 2) * kOctantEdge + z] & rows;
      }
      all |= static_cast<unsigned>(in_all == rows) << octant;
      any |= static_cast<unsigned>(in_any != 0) << octant;
    }
    if ((any & ~(all | Volume::known_octants(place))) == 0) {
      add_free_octants(evidence, static_cast<OctantMask>(all), num_free, pools, volume, chunk,
                       place);
      return 0;
    }
  }
  Block* block = volume.make_block(pools, chunk, place);
  if (block == nullptr) {
    for (const std::uint64_t word : hit.word) num_free += std::popcount(word);
    return static_cast<std::size_t>(num_free);
  }
  const Changes changes = add_evidence(evidence, free, crossed, hit, *block);
  Volume::set_rest(place, changes.may_rest());
  if (!has_hits && highest_in(*block) <= 0) volume.settle_block(pools, chunk, place);
  return 0;
}

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
