#pragma once

#include <cstdint>
#include <vector>

#include "firmware_interface/map/map_contents.hpp"

namespace cloister {

/// What two maps of one mission say about a submap, voxel by voxel: free, occupied or unknown.
struct SubmapDifference {
  SubmapId id = kNoSubmap;
  bool is_in_both = false;
  std::size_t observed = 0;   ///< voxels that either knows
  std::size_t differing = 0;  ///< of these, where the two do not say the same
};

struct MapDifference {
  std::vector<SubmapDifference> submaps;  ///< ascending id

  [[nodiscard]] std::size_t observed() const;
  [[nodiscard]] std::size_t differing() const;
  /// Of all observed voxels; 0 when there are none.
  [[nodiscard]] double share() const;
};

/// Compares submaps of the same id in their own frames: where the two maps place them does not matter. What a submap
/// knows that the other map does not have differs as a whole.
[[nodiscard]] MapDifference compare_maps(const MapView& a, const MapView& b);

}  // namespace cloister
