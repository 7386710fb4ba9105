#include "firmware_interface/output/report_tables.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>

#include "firmware_interface/files/text_format.hpp"
#include "firmware_interface/output/events_jsonl.hpp"
#include "firmware_interface/output/page_text.hpp"
#include "firmware_interface/output/submap_colour.hpp"
#include "mapping/core/config_fields.hpp"

namespace cloister {
namespace {

constexpr std::size_t kMaxEvents = 300;
constexpr std::size_t kMaxSubmaps = 300;
constexpr std::size_t kMaxMergedIds = 24;

std::string submap_chip(SubmapId id) {
  if (id == kNoSubmap) return "";
  std::string out;
  put(out, "<span class=\"chip\" style=\"background:", hex_colour(submap_colour(id)), "\"></span>",
      id);
  return out;
}

void put_cell(std::string& out, std::string_view css, std::string_view content) {
  if (css.empty())
    put(out, "<td>", content, "</td>");
  else
    put(out, "<td class=\"", css, "\">", content, "</td>");
}

std::string optional_number(double value, int decimals) {
  return value < 0 ? std::string() : fixed(value, decimals);
}

std::string id_list(const std::vector<SubmapId>& ids) {
  std::string out;
  for (std::size_t i = 0; i < std::min(ids.size(), kMaxMergedIds); ++i) {
    put(out, i == 0 ? "" : ", ", ids[i]);
  }
  if (ids.size() > kMaxMergedIds) put(out, " and ", ids.size() - kMaxMergedIds, " more");
  return out;
}

// The smaller, the sooner an event gets its line when there are too many.
int rank(EventKind kind) {
  switch (kind) {
    case EventKind::kFusionAccepted:
    case EventKind::kLoopClosure:
      return 0;
    case EventKind::kSpawn:
    case EventKind::kDegrade:
      return 1;
    case EventKind::kFusionRejected:
      return 2;
    case EventKind::kSpill:
    case EventKind::kReload:
      return 3;
    case EventKind::kOverlapChecked:
      return 4;
    case EventKind::kGraphUpdated:
    case EventKind::kDrop:
      return 5;
  }
  return 6;
}

std::vector<std::size_t> events_to_show(const std::vector<Event>& events) {
  std::vector<std::size_t> order(events.size());
  std::iota(order.begin(), order.end(), 0u);
  if (order.size() <= kMaxEvents) return order;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rank(events[a].kind) < rank(events[b].kind);
  });
  order.resize(kMaxEvents);
  std::sort(order.begin(), order.end());
  return order;
}

std::string spaced_name(EventKind kind) {
  std::string name(event_name(kind));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string_view colour_class(EventKind kind) {
  if (kind == EventKind::kFusionAccepted) return "accepted";
  if (kind == EventKind::kFusionRejected || kind == EventKind::kDrop) return "rejected";
  return "";
}

std::string detail(const Event& event) {
  std::string out = escape_xml(event.reason);
  if (event.count < 0) return out;
  if (!out.empty()) out += " · ";
  put(out, grouped(event.count),
      event.kind != EventKind::kGraphUpdated ? ""
      : event.count == 1                     ? " node"
                                             : " nodes");
  return out;
}

void put_event_row(std::string& out, const Event& event, SensorTime begin) {
  out += "<tr>";
  put_cell(out, "n", clock_text((event.stamp - begin).seconds(), 1));
  put_cell(out, colour_class(event.kind), spaced_name(event.kind));
  put_cell(out, "", submap_chip(event.a));
  put_cell(out, "", submap_chip(event.b));
  put_cell(out, "n", optional_number(event.ratio_a, 3));
  put_cell(out, "n", optional_number(event.ratio_b, 3));
  for (const double sigma_m : event.sigma_m) put_cell(out, "n", optional_number(sigma_m, 3));
  put_cell(out, "n soft", event.node_a == kNoNode ? "" : std::to_string(event.node_a));
  put_cell(out, "n soft", event.node_b == kNoNode ? "" : std::to_string(event.node_b));
  put_cell(out, "", detail(event));
  out += "</tr>\n";
}

std::string event_counts(const std::vector<Event>& events) {
  std::string out;
  for (int k = 0; k <= static_cast<int>(EventKind::kDrop); ++k) {
    const auto kind = static_cast<EventKind>(k);
    const auto count = std::count_if(events.begin(), events.end(),
                                     [kind](const Event& e) { return e.kind == kind; });
    if (count == 0) continue;
    put(out, out.empty() ? "" : " · ", grouped(count), " ", spaced_name(kind));
  }
  return out;
}

template <typename Map>
std::string counts_table(std::string_view title, const Map& counts) {
  std::string out;
  put(out, "<div><h3>", title, "</h3>\n");
  if (counts.empty()) {
    out += "<p class=\"soft small\">None.</p></div>\n";
    return out;
  }
  out += "<div class=\"scroll\"><table><tbody>\n";
  for (const auto& [name, count] : counts) {
    put(out, "<tr><td>", escape_xml(name), "</td><td class=\"n\">", grouped(count), "</td></tr>\n");
  }
  out += "</tbody></table></div></div>\n";
  return out;
}

std::vector<float> durations(const MissionRecord& record, float TimelineRow::*duration_ms) {
  std::vector<float> values;
  for (const TimelineRow& row : record.timeline) values.push_back(row.*duration_ms);
  return values;
}

}  // namespace

std::string submaps_table(const MissionRecord& record) {
  if (record.submaps.empty()) return "<p class=\"soft\">No submap was made.</p>\n";
  std::string out =
      "<div class=\"scroll\"><table><thead><tr><th>Submap</th><th class=\"n\">Nodes</th>"
      "<th class=\"n\">Scans</th><th class=\"n\">Extent, m</th><th class=\"n\">Observed, m³</th>"
      "<th class=\"n\">Blocks</th><th class=\"n\">Memory</th><th>Merged "
      "from</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < std::min(record.submaps.size(), kMaxSubmaps); ++i) {
    const SubmapRecord& submap = record.submaps[i];
    const Eigen::Vector3d extent_m = submap.aabb_max_M - submap.aabb_min_M;
    std::string extent;
    put(extent, compact(extent_m.x(), 1), " × ", compact(extent_m.y(), 1), " × ",
        compact(extent_m.z(), 1));
    out += "<tr>";
    put_cell(out, "", submap_chip(submap.id));
    put_cell(out, "n", grouped(static_cast<std::int64_t>(submap.nodes.size())));
    put_cell(out, "n", grouped(static_cast<std::int64_t>(submap.scan_stamps.size())));
    put_cell(out, "n", extent);
    put_cell(out, "n", readable(submap.observed_m3));
    put_cell(out, "n", grouped(submap.blocks));
    put_cell(out, "n", byte_size(submap.bytes));
    put_cell(out, "ids soft", id_list(submap.merged_from));
    out += "</tr>\n";
  }
  out += "</tbody></table></div>\n";
  if (record.submaps.size() > kMaxSubmaps) {
    put(out, "<p class=\"soft small\">", record.submaps.size() - kMaxSubmaps,
        " more in <code>submaps.json</code>.</p>\n");
  }
  return out;
}

std::string decisions_table(const MissionRecord& record) {
  const std::vector<Event>& events = record.events;
  if (events.empty()) return "<p class=\"soft\">No decision was taken.</p>\n";
  SensorTime begin = events.front().stamp;
  if (!record.timeline.empty()) begin = std::min(begin, record.timeline.front().stamp);
  const std::vector<std::size_t> shown = events_to_show(events);
  std::string out;
  put(out, "<p class=\"soft small\">", event_counts(events), "</p>\n");
  out +=
      "<div class=\"scroll\"><table><thead><tr><th "
      "class=\"n\">Time</th><th>Event</th><th>a</th><th>b</th>"
      "<th class=\"n\">Ratio a</th><th class=\"n\">Ratio b</th><th class=\"n\">σ₁, m</th><th "
      "class=\"n\">σ₂, m</th>"
      "<th class=\"n\">σ₃, m</th><th class=\"n\">Node a</th><th class=\"n\">Node "
      "b</th><th>Reason</th></tr></thead><tbody>\n";
  for (const std::size_t i : shown) put_event_row(out, events[i], begin);
  out += "</tbody></table></div>\n";
  if (shown.size() < events.size()) {
    put(out, "<p class=\"soft small\">",
        grouped(static_cast<std::int64_t>(events.size() - shown.size())),
        " more in <code>events.jsonl</code>.</p>\n");
  }
  return out;
}

std::string timing_table(const MissionRecord& record) {
  const MissionRecord& r = record;
  std::string out =
      "<div class=\"scroll wide\"><table><thead><tr><th>Stage</th><th class=\"n\">Calls</th><th "
      "class=\"n\">p50, ms</th>"
      "<th class=\"n\">p95, ms</th><th class=\"n\">p99, ms</th><th class=\"n\">max, ms</th><th "
      "class=\"n\">CPU, s</th>"
      "</tr></thead><tbody>\n";
  const auto row = [&out](std::string_view stage, const std::vector<float>* durations_ms,
                          double cpu_s) {
    put(out, "<tr><td>", stage, "</td>");
    if (durations_ms != nullptr) {
      const TimingSummary timing = summarise(*durations_ms);
      put_cell(out, "n", grouped(static_cast<std::int64_t>(durations_ms->size())));
      for (const double ms : {timing.p50, timing.p95, timing.p99, timing.max})
        put_cell(out, "n", readable(ms));
    } else {
      out += "<td></td><td></td><td></td><td></td><td></td>";
    }
    put_cell(out, "n", cpu_s < 0 ? "" : fixed(cpu_s, 2));
    out += "</tr>\n";
  };
  const std::vector<float> integrate_ms = durations(r, &TimelineRow::integrate_ms);
  const std::vector<float> latency_ms = durations(r, &TimelineRow::latency_ms);
  row("Decoding", nullptr, r.cpu_decode_s);
  row("Spawn check", nullptr, r.cpu_spawn_check_s);
  row("Integration", &integrate_ms, r.cpu_integration_s);
  row("Latency", &latency_ms, -1);
  row("Voxel overlap", &r.overlap_ms, r.cpu_overlap_s);
  row("Relative uncertainty", &r.uncertainty_ms, r.cpu_uncertainty_s);
  row("Fusion", &r.fuse_ms, r.cpu_fusion_s);
  row("All threads", nullptr, r.cpu_total_s);
  out += "</tbody></table></div>\n";
  return out;
}

std::string counts_tables(const MissionRecord& record) {
  return "<div class=\"pair\">\n" + counts_table("Dropped, by cause", record.drops) +
         counts_table("Counters", record.counters) + "</div>\n";
}

std::string config_list(const Config& config) {
  std::string out = "<ul class=\"config mono\">\n";
  visit_fields(config, [&out](std::string_view name, const auto& value, auto, auto) {
    put(out, "<li><span class=\"soft\">", name, "</span><span>");
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, bool>) {
      out += value ? "true" : "false";
    } else {
      append_number(out, value);
    }
    out += "</span></li>\n";
  });
  out += "</ul>\n";
  return out;
}

}  // namespace cloister
