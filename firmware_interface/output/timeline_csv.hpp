#pragma once

#include <string>
#include <vector>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The text of timeline.csv: a header and one row a scan, in the order of integration. `submap` is
/// -1 for a scan that went nowhere; milliseconds and ratios have the shortest form that reads back
/// to the same float.
[[nodiscard]] std::string timeline_csv(const std::vector<TimelineRow>& timeline);

}  // namespace cloister
