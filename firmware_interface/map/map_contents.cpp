#include "firmware_interface/map/map_contents.hpp"

#include <algorithm>

namespace cloister {

LoadedMap copy_map(const MapView& map) {
  LoadedMap copy;
  copy.info = map.info;
  const std::vector<const Submap*> submaps = sorted_submaps(map);
  std::size_t num_blocks = 0, num_chunks = 0;
  for (const Submap* submap : submaps) {
    num_blocks += submap->volume.num_blocks();
    num_chunks += submap->volume.num_chunks();
  }
  copy.store = std::make_unique<VoxelStore>(num_blocks, num_chunks);
  copy.pools = std::make_unique<VoxelPools>(*copy.store);
  copy.pools->take_all();
  copy.submaps.resize(submaps.size());
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const Submap& from = *submaps[i];
    Submap& to = copy.submaps[i];
    to.id = from.id;
    to.root = from.root;
    to.spawned = from.spawned;
    to.T_root_S = from.T_root_S;
    to.T_M_S = from.T_M_S;
    // The store has exactly as much room as is needed: nothing is ever declined.
    from.volume.for_each_block(*map.store, [&](const BlockCoord& coord, const BlockView& view) {
      Chunk* chunk = nullptr;
      std::uint32_t* place = to.volume.make_place(*copy.pools, coord, &chunk);
      if (view.block != nullptr) {
        *to.volume.make_block(*copy.pools, *chunk, *place) = *view.block;
      } else {
        to.volume.set_coarse(*copy.pools, *chunk, *place, view.coarse, view.known);
      }
    });
    copy.submap_ptrs.push_back(&to);
  }
  return copy;
}

std::vector<const Submap*> sorted_submaps(const MapView& map) {
  std::vector<const Submap*> submaps(map.submaps.begin(), map.submaps.end());
  std::sort(submaps.begin(), submaps.end(),
            [](const Submap* a, const Submap* b) { return a->id < b->id; });
  return submaps;
}

}  // namespace cloister
