#include "firmware_interface/map/map_contents.hpp"

#include <algorithm>

namespace cloister {

std::vector<const Submap*> sorted_submaps(const MapView& map) {
  std::vector<const Submap*> submaps(map.submaps.begin(), map.submaps.end());
  std::sort(submaps.begin(), submaps.end(),
            [](const Submap* a, const Submap* b) { return a->id < b->id; });
  return submaps;
}

}  // namespace cloister
