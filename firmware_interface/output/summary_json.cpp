#include "firmware_interface/output/summary_json.hpp"

#include <cstdio>

#include "firmware_interface/output/config_json.hpp"

namespace cloister {
namespace {

using Json = nlohmann::ordered_json;

Json timing_json(const TimingSummary& timing) {
  return {{"p50", timing.p50}, {"p95", timing.p95}, {"p99", timing.p99}, {"max", timing.max}};
}

TimingSummary timeline_timing(const MissionRecord& record, float TimelineRow::*duration_ms) {
  std::vector<float> durations_ms;
  durations_ms.reserve(record.timeline.size());
  for (const TimelineRow& row : record.timeline) durations_ms.push_back(row.*duration_ms);
  return summarise(std::move(durations_ms));
}

std::string hexadecimal(std::uint64_t value) {
  char text[19];
  std::snprintf(text, sizeof(text), "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

std::string summary_json(const MissionRecord& record) {
  const MissionRecord& r = record;
  Json json;
  json["mission"] = r.mission;
  json["cloister_version"] = CLOISTER_VERSION;
  json["interrupted"] = r.interrupted;
  json["baseline"] = r.config.baseline;
  json["voxel_size_m"] = r.config.voxel.voxel_size_m;
  json["min_range_m"] = r.config.voxel.min_range_m;
  json["max_range_m"] = r.config.voxel.max_range_m;
  json["scans"] = {
      {"read", r.scans_read}, {"integrated", r.scans_integrated}, {"dropped", r.scans_dropped}};
  json["returns_integrated"] = r.returns_integrated;
  json["duration_s"] = r.duration_s;
  json["travel_m"] = r.travel_m;
  json["submaps"] = {{"spawned", r.submaps_spawned},
                     {"fused", r.submaps_fused},
                     {"final", r.submaps_final},
                     {"peak", r.submaps_peak}};
  json["observed_m3"] = r.observed_m3;
  json["fusions"] = {{"proposed_by_loop", r.fusions_proposed_by_loop},
                     {"proposed_by_overlap", r.fusions_proposed_by_overlap},
                     {"accepted", r.fusions_accepted},
                     {"rejected_by_uncertainty", r.fusions_rejected_by_uncertainty},
                     {"rejected_by_overlap", r.fusions_rejected_by_overlap}};
  json["memory"] = {{"budget_bytes", r.budget_bytes},       {"map_bytes_peak", r.map_bytes_peak},
                    {"map_bytes_final", r.map_bytes_final}, {"spilled_bytes", r.spilled_bytes},
                    {"rss_peak_bytes", r.rss_peak_bytes},   {"cloud_bytes", r.cloud_bytes}};
  json["timing_ms"] = {{"integrate", timing_json(timeline_timing(r, &TimelineRow::integrate_ms))},
                       {"latency", timing_json(timeline_timing(r, &TimelineRow::latency_ms))},
                       {"overlap", timing_json(summarise(r.overlap_ms))},
                       {"fuse", timing_json(summarise(r.fuse_ms))},
                       {"uncertainty", timing_json(summarise(r.uncertainty_ms))}};
  // What integration is judged by, however busy the machine is: CPU time, and its one scan in a thousand as well.
  const TimingSummary cpu = timeline_timing(r, &TimelineRow::integration_cpu_ms);
  Json& cpu_json = json["timing_ms"]["integration_cpu"] = timing_json(cpu);
  cpu_json["p999"] = cpu.p999;
  json["cpu_s"] = {{"decode", r.cpu_decode_s},
                   {"spawn_check", r.cpu_spawn_check_s},
                   {"integration", r.cpu_integration_s},
                   {"overlap", r.cpu_overlap_s},
                   {"uncertainty", r.cpu_uncertainty_s},
                   {"fusion", r.cpu_fusion_s},
                   {"total", r.cpu_total_s}};
  json["drops"] = r.drops;
  json["map_hash"] = hexadecimal(r.map_hash);
  json["counters"] = r.counters;
  json["warnings"] = r.warnings;
  json["config"] = config_json(r.config);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace cloister
