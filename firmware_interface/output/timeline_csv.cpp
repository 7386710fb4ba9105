#include "firmware_interface/output/timeline_csv.hpp"

#include "firmware_interface/files/text_format.hpp"

namespace cloister {

std::string timeline_csv(const std::vector<TimelineRow>& timeline) {
  std::string text =
      "stamp_ns,submap,integrate_ms,latency_ms,submaps,map_bytes,queue_depth,overlap_ratio\n";
  const auto cell = [&text](auto value, char end) {
    append_number(text, value);
    text += end;
  };
  for (const TimelineRow& row : timeline) {
    cell(row.stamp.ns, ',');
    cell(row.submap, ',');
    cell(row.integrate_ms, ',');
    cell(row.latency_ms, ',');
    cell(row.submaps, ',');
    cell(row.map_bytes, ',');
    cell(row.queue_depth, ',');
    cell(row.overlap_ratio, '\n');
  }
  return text;
}

}  // namespace cloister
