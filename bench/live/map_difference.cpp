#include "bench/live/map_difference.hpp"

#include <map>
#include <utility>

namespace cloister {
namespace {

void compare_blocks(const BlockView& a, const BlockView& b, SubmapDifference& difference) {
  for (int i = 0; i < kBlockVoxels; ++i) {
    const VoxelState of_a = state_of(a.at(i)), of_b = state_of(b.at(i));
    difference.observed += of_a != VoxelState::kUnknown || of_b != VoxelState::kUnknown ? 1 : 0;
    difference.differing += of_a != of_b ? 1 : 0;
  }
}

}  // namespace

std::size_t MapDifference::observed() const {
  std::size_t sum = 0;
  for (const SubmapDifference& submap : submaps) sum += submap.observed;
  return sum;
}

std::size_t MapDifference::differing() const {
  std::size_t sum = 0;
  for (const SubmapDifference& submap : submaps) sum += submap.differing;
  return sum;
}

double MapDifference::share() const {
  const std::size_t all = observed();
  return all == 0 ? 0 : static_cast<double>(differing()) / static_cast<double>(all);
}

MapDifference compare_maps(const MapView& a, const MapView& b) {
  std::map<SubmapId, std::pair<const Submap*, const Submap*>> pairs;
  for (const Submap* submap : a.submaps) pairs[submap->id].first = submap;
  for (const Submap* submap : b.submaps) pairs[submap->id].second = submap;
  const Volume nothing;
  MapDifference result;
  for (const auto& [id, pair] : pairs) {
    const Volume& of_a = pair.first != nullptr ? pair.first->volume : nothing;
    const Volume& of_b = pair.second != nullptr ? pair.second->volume : nothing;
    SubmapDifference difference{id, pair.first != nullptr && pair.second != nullptr};
    of_a.for_each_block(*a.store, [&](const BlockCoord& coord, const BlockView& view) {
      compare_blocks(view, of_b.view(*b.store, coord), difference);
    });
    of_b.for_each_block(*b.store, [&](const BlockCoord& coord, const BlockView& view) {
      // What a knows of as well is counted already.
      if (of_a.view(*a.store, coord).is_unknown()) compare_blocks({}, view, difference);
    });
    result.submaps.push_back(difference);
  }
  return result;
}

}  // namespace cloister
