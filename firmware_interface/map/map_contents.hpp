#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mapping/submap/submap.hpp"
#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// What must be known about a map beside its submaps.
struct MapInfo {
  double voxel_size_m = 0.065;
  /// Bounds of a voxel's evidence, natural log-odds; combined answers keep them too.
  double log_odds_min = -2.0;
  double log_odds_max = 3.5;
};

/// A map as it stands in somebody's memory: everything that can be saved, meshed or exported.
/// Owns nothing.
///
/// Threads: whoever uses a view reads the submaps, and needs their owner's permission for as long.
struct MapView {
  MapInfo info;
  const VoxelStore* store = nullptr;
  std::span<const Submap* const> submaps;  ///< ids are unique; any order
};

/// A map with memory of its own, sized for exactly what it holds.
struct LoadedMap {
  MapInfo info;
  std::unique_ptr<VoxelStore> store;
  std::unique_ptr<VoxelPools> pools;
  std::vector<Submap> submaps;             ///< ascending id
  std::vector<const Submap*> submap_ptrs;  ///< the same, as MapView wants them

  [[nodiscard]] MapView view() const { return {info, store.get(), submap_ptrs}; }
};

/// A copy of what the submaps are and know, without their histories. Allocates as much as they take.
[[nodiscard]] LoadedMap copy_map(const MapView& map);

/// The submaps of a map by ascending id.
[[nodiscard]] std::vector<const Submap*> sorted_submaps(const MapView& map);

}  // namespace cloister
