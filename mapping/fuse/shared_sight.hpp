#pragma once

#include "mapping/submap/submap.hpp"
#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// How well the places of two submaps' sensors see each other: the share of straight lines between them that run through
/// space which is mostly known and nowhere occupied in either. Places are up to ten points of each path, and what lies a
/// metre aside of them: through doors in one line a straight path sees another one whole, but from further aside than a
/// door is wide nothing of it.
///
/// @return 0 to 1; at least 0.8 for four of five pairs in one room, for next to none in different rooms
/// Cost: up to 2,500 lines. Threads: reads both volumes; needs their owner's permission. Allocates.
[[nodiscard]] double shared_sight(const VoxelStore& store, double voxel_size_m, const Submap& a,
                                  const Submap& b);

}  // namespace cloister
