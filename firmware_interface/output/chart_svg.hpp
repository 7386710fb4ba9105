#pragma once

#include <string>
#include <vector>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// Memory of the map above, number of submaps below, over the mission's time; the budget's line
/// where it is near. Long timelines are drawn by the first, least, most and last value of each of
/// some hundred intervals.
/// @return an <svg> element, 520 units wide, for a page that styles the classes as report_style.hpp
///         does; empty without scans
[[nodiscard]] std::string growth_chart_svg(const MissionRecord& record);

/// Histograms of integration time and latency over one logarithmic axis, with their medians and
/// 99th percentiles. An <svg> element of the same kind.
[[nodiscard]] std::string timing_chart_svg(const MissionRecord& record);

/// A value over time.
struct Sample {
  double t = 0, value = 0;
};

/// At most four samples for each of `intervals` equal spans of time (first, least, most, last), in
/// order; short series are returned as they are.
/// @param samples ascending in t
[[nodiscard]] std::vector<Sample> thin(const std::vector<Sample>& samples, int intervals);

}  // namespace cloister
