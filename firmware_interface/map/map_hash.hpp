#pragma once

#include <cstdint>
#include <span>

#include "mapping/submap/submap.hpp"

namespace cloister {

/// XXH3-64 of what a map says: for each submap, by ascending id, its id, the bits of T_M_S and its
/// chunks in the order of their coordinates. Where blocks lie in the pools, and the order in which
/// anything was made, do not matter. Threads: reads the submaps; needs their owner's permission.
[[nodiscard]] std::uint64_t map_hash(const VoxelStore& store,
                                     std::span<const Submap* const> submaps);

}  // namespace cloister
