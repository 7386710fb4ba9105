#include "firmware_interface/output/events_jsonl.hpp"

#include <nlohmann/json.hpp>

namespace cloister {
namespace {

using Json = nlohmann::ordered_json;

// A record marks "none" by a negative number; NaN becomes null in JSON by itself.
template <typename Number>
Json or_null(Number value) {
  return value < 0 ? Json(nullptr) : Json(value);
}

template <typename Number>
void put_if_known(Json& json, const char* key, Number value) {
  if (value >= 0) json[key] = value;
}

void put_pair(Json& json, const Event& event) {
  json["a"] = or_null(event.a);
  json["b"] = or_null(event.b);
  json["ratio_a"] = or_null(event.ratio_a);
  json["ratio_b"] = or_null(event.ratio_b);
  json["sigma_m"] = {or_null(event.sigma_m[0]), or_null(event.sigma_m[1]),
                     or_null(event.sigma_m[2])};
  json["root_a"] = or_null(event.node_a);
  json["root_b"] = or_null(event.node_b);
  put_if_known(json, "shift_m", event.shift_m);
}

Json event_json(const Event& event) {
  Json json;
  json["stamp_ns"] = event.stamp.ns;
  json["event"] = event_name(event.kind);
  switch (event.kind) {
    case EventKind::kSpawn:
      put_if_known(json, "submap", event.a);
      put_if_known(json, "overlap_ratio", event.ratio_a);
      put_if_known(json, "root_node", event.node_a);
      break;
    case EventKind::kLoopClosure:
      put_if_known(json, "node_a", event.node_a);
      put_if_known(json, "node_b", event.node_b);
      put_if_known(json, "a", event.a);
      put_if_known(json, "b", event.b);
      break;
    case EventKind::kOverlapChecked:
    case EventKind::kFusionAccepted:
    case EventKind::kFusionRejected:
      put_pair(json, event);
      break;
    case EventKind::kGraphUpdated:
      put_if_known(json, "nodes", event.count);
      break;
    case EventKind::kSpill:
    case EventKind::kReload:
    case EventKind::kDegrade:
    case EventKind::kDrop:
      put_if_known(json, "submap", event.a);
      put_if_known(json, "count", event.count);
      break;
  }
  if (!event.reason.empty()) json["reason"] = event.reason;
  return json;
}

}  // namespace

std::string_view event_name(EventKind kind) {
  switch (kind) {
    case EventKind::kSpawn:
      return "spawn";
    case EventKind::kLoopClosure:
      return "loop_closure";
    case EventKind::kOverlapChecked:
      return "overlap_checked";
    case EventKind::kFusionAccepted:
      return "fusion_accepted";
    case EventKind::kFusionRejected:
      return "fusion_rejected";
    case EventKind::kGraphUpdated:
      return "graph_updated";
    case EventKind::kSpill:
      return "spill";
    case EventKind::kReload:
      return "reload";
    case EventKind::kDegrade:
      return "degrade";
    case EventKind::kDrop:
      return "drop";
  }
  return "unknown";
}

std::string events_jsonl(const std::vector<Event>& events) {
  std::string text;
  for (const Event& event : events) {
    text += event_json(event).dump(-1, ' ', false, Json::error_handler_t::replace);
    text += '\n';
  }
  return text;
}

}  // namespace cloister
