#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/ground_truth/truth.hpp"

namespace cloister {

/// How submaps share out one room.
struct RoomShare {
  Room room;
  std::size_t scans = 0;    ///< taken well inside it
  std::size_t submaps = 0;  ///< final submaps that hold at least a tenth of them
};

/// How well final submaps and rooms correspond.
struct RoomAccuracy {
  std::vector<RoomShare> rooms;
  std::size_t final_submaps = 0;
  std::size_t scans = 0;             ///< all that lie well inside a room
  double adjusted_rand_index = 0.0;  ///< 1 = submaps are rooms, 0 = no better than chance
};

/// Compares two labelings of the same things (Hubert and Arabie 1985). 1 when both put everything in one class.
[[nodiscard]] double adjusted_rand_index(
    const std::vector<std::pair<std::int64_t, std::int64_t>>& labels);

/// Counts, for scans taken at least `margin_m` inside a room's walls: doorways belong to two rooms.
[[nodiscard]] RoomAccuracy compare_rooms(const GroundTruth& truth,
                                         const std::vector<SubmapScans>& submaps,
                                         double margin_m = 0.6);

}  // namespace cloister
