#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The word for a kind of event in events.jsonl and in the report, such as "fusion_accepted".
[[nodiscard]] std::string_view event_name(EventKind kind);

/// The text of events.jsonl: one JSON object a line, each with `stamp_ns` and `event`, and `reason`
/// where there is one.
///
/// | event                        | further fields                                                |
/// |------------------------------|---------------------------------------------------------------|
/// | spawn                        | submap, overlap_ratio, root_node                              |
/// | loop_closure                 | node_a, node_b, a, b                                          |
/// | overlap_checked,             | a, b, ratio_a, ratio_b, sigma_m[3], root_a, root_b;           |
/// | fusion_accepted, _rejected   | always there, null where not measured; of an accepted fusion, |
/// |                              | shift_m: how far surfaces laid b from where the graph has it  |
/// | graph_updated                | nodes                                                         |
/// | spill, reload, degrade, drop | submap, count                                                 |
///
/// Outside of checks and fusions, fields that do not apply are left out.
[[nodiscard]] std::string events_jsonl(const std::vector<Event>& events);

}  // namespace cloister
