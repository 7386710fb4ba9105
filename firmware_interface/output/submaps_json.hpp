#pragma once

#include <string>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The text of submaps.json: a list with one line a submap: what it was merged from, its root node
/// and pose in M (x, y, z in metres, then a unit quaternion with qw >= 0), the box of its known
/// voxels in M, the nodes and scans it holds, its memory and `observed_m3`. `root_node` is -1 while
/// no graph is known; numbers that are not finite are null.
[[nodiscard]] std::string submaps_json(const std::vector<SubmapRecord>& submaps);

}  // namespace cloister
