#include "bench/experiments/limits.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace cloister {

namespace {

constexpr double kMega = 1e6;
constexpr std::int64_t kCampusBytes = 512'000'000;

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
  char buffer[160];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof(buffer), format, arguments);
  va_end(arguments);
  return buffer;
}

std::string count(std::int64_t value) { return std::to_string(value); }
std::string percent(double share) { return text("%.2f %%", 100.0 * share); }
std::string megabytes(std::int64_t bytes) {
  return text("%.2f MB", static_cast<double>(bytes) / kMega);
}
std::string milliseconds(double p50, double p99) { return text("%.1f / %.1f ms", p50, p99); }

/// Collects lines; knows whether the mission is long enough for limits about all of it.
class Lines {
 public:
  explicit Lines(const Experiment& experiment) : is_cut_short_(experiment.is_cut_short) {}

  void figure(std::string what, std::string ours, std::string baseline = {}) {
    lines_.push_back({std::move(what), std::move(ours), std::move(baseline), {}, {}});
  }
  void limit(std::string what, std::string ours, std::string baseline, std::string limit,
             bool is_met) {
    lines_.push_back({std::move(what), std::move(ours), std::move(baseline), std::move(limit),
                      is_met ? "PASS" : "FAIL"});
  }
  /// A limit that only a whole mission can be held to.
  void whole(std::string what, std::string ours, std::string baseline, std::string limit,
             bool is_met) {
    this->limit(std::move(what), std::move(ours), std::move(baseline), std::move(limit), is_met);
    if (is_cut_short_) lines_.back().verdict += '*';
  }
  [[nodiscard]] std::vector<Line> take() { return std::move(lines_); }

 private:
  bool is_cut_short_;
  std::vector<Line> lines_;
};

void add_fault(const Experiment& e, Lines* lines) {
  if (e.fault != GraphFault::kDoubtedClosures && e.fault != GraphFault::kWrongClosures) return;
  lines->figure("wrong loop closures", count(static_cast<std::int64_t>(e.wrong_closures)));
  const std::string across = count(static_cast<std::int64_t>(e.fused_across));
  if (e.fault == GraphFault::kDoubtedClosures) {
    lines->limit("fused across one", across, {}, "none", e.fused_across == 0);
  } else {
    lines->figure("fused across one", across);
  }
}

void add_submaps(const Experiment& e, Lines* lines) {
  const std::string final = count(e.ours.submaps_final);
  const std::string base_final = count(e.baseline.submaps_final);
  lines->figure("submaps spawned", count(e.ours.submaps_spawned),
                count(e.baseline.submaps_spawned));
  lines->figure("submaps at the peak", count(e.ours.submaps_peak), count(e.baseline.submaps_peak));
  if (e.world == "small-rooms") {
    lines->whole("submaps at the end", final, base_final, "9 to 18",
                 e.ours.submaps_final >= 9 && e.ours.submaps_final <= 18);
    lines->limit("adjusted Rand index", text("%.3f", e.rand_index), {}, "at least 0.8",
                 e.rand_index >= 0.8);
  } else if (e.world == "large-rooms") {
    lines->whole("submaps at the end", final, base_final, "at most 70", e.ours.submaps_final <= 70);
    lines->figure("adjusted Rand index", text("%.3f", e.rand_index));
    if (e.middle_room_submaps) {
      lines->whole("submaps of the middle room", count(*e.middle_room_submaps), {}, "1 or 2",
                   *e.middle_room_submaps >= 1 && *e.middle_room_submaps <= 2);
    }
  } else {
    lines->figure("submaps at the end", final, base_final);
    if (e.world != "campus") lines->figure("adjusted Rand index", text("%.3f", e.rand_index));
  }
  if (e.world == "three-storey") {
    lines->limit("submaps across storeys",
                 count(static_cast<std::int64_t>(e.submaps_across_storeys)), {}, "none",
                 e.submaps_across_storeys == 0);
  }
  lines->limit("pairs left to fuse", count(static_cast<std::int64_t>(e.overlapping_pairs)), {},
               "none", e.overlapping_pairs == 0);
  lines->figure("overlapping pairs in doubt", count(static_cast<std::int64_t>(e.doubtful_pairs)));
}

void add_memory(const Experiment& e, Lines* lines) {
  const std::string peak = megabytes(e.ours.map_bytes_peak);
  const std::string base_peak = megabytes(e.baseline.map_bytes_peak);
  if (e.world == "campus") {
    lines->whole("map at the peak", peak, base_peak, "at most 512 MB",
                 e.ours.map_bytes_peak <= kCampusBytes);
  } else {
    lines->figure("map at the peak", peak, base_peak);
  }
  lines->figure("map at the end", megabytes(e.ours.map_bytes_final),
                megabytes(e.baseline.map_bytes_final));
  const bool is_rooms = e.world == "small-rooms" || e.world == "large-rooms";
  if (is_rooms || e.world == "campus") {
    const double least = is_rooms ? 0.6 : 0.7;
    lines->whole("memory saved at the end", percent(e.memory_saved()), {},
                 text("at least %.0f %%", 100.0 * least), e.memory_saved() >= least);
  } else {
    lines->figure("memory saved at the end", percent(e.memory_saved()));
  }
  const double added = growth_in_last_third(e.ours.growth);
  const std::string base_added = percent(growth_in_last_third(e.baseline.growth));
  if (e.world == "campus") {
    lines->whole("added by the last third", percent(added), base_added, "at most 10 %",
                 added <= 0.10);
  } else {
    lines->figure("added by the last third", percent(added), base_added);
  }
  const std::vector<std::int64_t> bytes = e.round_bytes();
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const std::string what = "map after round " + std::to_string(k + 1);
    const std::string base = megabytes(map_bytes_at(e.baseline.growth, e.round_ends[k]));
    if (k == 0) {
      lines->figure(what, megabytes(bytes[k]), base);
      continue;
    }
    const double more = static_cast<double>(bytes[k]) / static_cast<double>(bytes[0]) - 1.0;
    const std::string ours = megabytes(bytes[k]) + text(" (%+.1f %%)", 100.0 * more);
    if (k == 5) {
      lines->limit(what, ours, base, "at most +5 %", more <= 0.05);
    } else {
      lines->figure(what, ours, base);
    }
  }
  if (e.world == "small-rooms" && bytes.size() < 6)
    lines->whole("rounds walked", count(static_cast<std::int64_t>(bytes.size())), {}, "6", false);
}

void add_accuracy(const Experiment& e, Lines* lines) {
  const auto shares = [](const Nearness& n) {
    return text("%.2f / %.2f / %.2f %%", 100.0 * n.within_5cm, 100.0 * n.within_10cm,
                100.0 * n.within_25cm);
  };
  lines->figure("trajectory, rms", text("%.1f cm", 100.0 * e.trajectory_rms_m));
  lines->figure("mesh within 5/10/25 cm", shares(e.mesh));
  lines->figure("perfect mapper's points", shares(e.returns));
  const double ratio =
      e.returns.within_10cm > 0.0 ? e.mesh.within_10cm / e.returns.within_10cm : 0.0;
  lines->limit("10 cm: mesh against perfect", text("%.4f", ratio), {}, "at least 0.97",
               ratio >= 0.97);
  if (e.world == "campus") {
    lines->limit("mesh within 25 cm", percent(e.mesh.within_25cm), {}, "at least 95 %",
                 e.mesh.within_25cm >= 0.95);
  }
  lines->limit("surface drawn twice", percent(e.doubled_share), {}, "below 1 %",
               e.doubled_share < 0.01);
  lines->figure("  with more than 10 cm between", percent(e.doubled_far_share));
  lines->figure("seen surface covered", percent(e.complete_10cm));
}

void add_time(const Experiment& e, Lines* lines) {
  const ReplayFigures& o = e.ours;
  const ReplayFigures& b = e.baseline;
  lines->figure("integration p50 / p99", milliseconds(o.integrate_p50_ms, o.integrate_p99_ms),
                milliseconds(b.integrate_p50_ms, b.integrate_p99_ms));
  lines->figure("latency p50 / p99", milliseconds(o.latency_p50_ms, o.latency_p99_ms),
                milliseconds(b.latency_p50_ms, b.latency_p99_ms));
  const auto cpu = [&](const char* what, double StageCpu::*stage) {
    lines->figure(std::string("CPU ") + what, text("%.2f s", o.cpu.*stage),
                  text("%.2f s", b.cpu.*stage));
  };
  cpu("decoding", &StageCpu::decode_s);
  cpu("spawn checks", &StageCpu::spawn_check_s);
  cpu("integration", &StageCpu::integration_s);
  cpu("overlap", &StageCpu::overlap_s);
  cpu("uncertainty", &StageCpu::uncertainty_s);
  cpu("fusion", &StageCpu::fusion_s);
  cpu("in all", &StageCpu::total_s);
}

}  // namespace

std::vector<Line> judge_lines(const Experiment& experiment) {
  Lines lines(experiment);
  add_fault(experiment, &lines);
  add_submaps(experiment, &lines);
  add_memory(experiment, &lines);
  add_accuracy(experiment, &lines);
  add_time(experiment, &lines);
  return lines.take();
}

std::string format_table(const Experiment& e, const std::vector<Line>& lines) {
  std::string table =
      text("%s: %lld scans, %.0f s, %.0f m%s\n", experiment_name(e).c_str(),
           static_cast<long long>(e.ours.scans), e.ours.duration_s, e.ours.travel_m,
           e.is_cut_short ? ", cut short" : "");
  table += text("  %-28s %26s %20s  %-15s\n", "", "ours", "baseline", "limit");
  bool has_star = false;
  for (const Line& line : lines) {
    std::string row = text("  %-28s %26s %20s  %-15s %s", line.what.c_str(), line.ours.c_str(),
                           line.baseline.c_str(), line.limit.c_str(), line.verdict.c_str());
    row.erase(row.find_last_not_of(' ') + 1);
    table += row + "\n";
    has_star = has_star || line.verdict.ends_with('*');
  }
  if (has_star) table += "  * a limit for whole missions, and this one was cut short\n";
  return table;
}

std::string format_csv(const std::vector<Experiment>& experiments, const Provenance& provenance) {
  // Head and rows come from the same calls, so that they cannot part.
  std::string head, rows;
  for (const Experiment& e : experiments) {
    std::string row;
    head.clear();
    const auto cell = [&](const std::string& name, const std::string& value) {
      head += (head.empty() ? "" : ",") + name;
      row += (row.empty() ? "" : ",") + value;
    };
    const auto whole = [&](const std::string& name, std::int64_t value) {
      cell(name, std::to_string(value));
    };
    const auto real = [&](const std::string& name, double value) {
      cell(name, text("%.6g", value));
    };
    cell("world", e.world);
    cell("seed", std::to_string(e.seed));
    cell("graph_fault", name_of(graph_fault_names(), e.fault));
    cell("clouds", e.clouds ? name_of(cloud_kind_names(), *e.clouds) : "none");
    whole("cut_short", e.is_cut_short ? 1 : 0);
    for (const auto& [prefix, r] :
         {std::pair<std::string, const ReplayFigures*>{"", &e.ours}, {"baseline_", &e.baseline}}) {
      whole(prefix + "scans", r->scans);
      real(prefix + "duration_s", r->duration_s);
      real(prefix + "travel_m", r->travel_m);
      whole(prefix + "submaps_spawned", r->submaps_spawned);
      whole(prefix + "submaps_peak", r->submaps_peak);
      whole(prefix + "submaps_final", r->submaps_final);
      whole(prefix + "map_bytes_peak", r->map_bytes_peak);
      whole(prefix + "map_bytes_final", r->map_bytes_final);
      real(prefix + "last_third_adds", growth_in_last_third(r->growth));
      real(prefix + "integrate_p50_ms", r->integrate_p50_ms);
      real(prefix + "integrate_p99_ms", r->integrate_p99_ms);
      real(prefix + "latency_p50_ms", r->latency_p50_ms);
      real(prefix + "latency_p99_ms", r->latency_p99_ms);
      real(prefix + "overlap_p99_ms", r->overlap_p99_ms);
      real(prefix + "cpu_decode_s", r->cpu.decode_s);
      real(prefix + "cpu_spawn_check_s", r->cpu.spawn_check_s);
      real(prefix + "cpu_integration_s", r->cpu.integration_s);
      real(prefix + "cpu_overlap_s", r->cpu.overlap_s);
      real(prefix + "cpu_uncertainty_s", r->cpu.uncertainty_s);
      real(prefix + "cpu_fusion_s", r->cpu.fusion_s);
      real(prefix + "cpu_total_s", r->cpu.total_s);
    }
    real("memory_saved", e.memory_saved());
    const auto bytes = e.round_bytes();
    for (std::size_t k = 0; k < 6; ++k) {
      cell(text("map_bytes_round_%zu", k + 1), k < bytes.size() ? std::to_string(bytes[k]) : "");
    }
    real("adjusted_rand_index", e.rand_index);
    cell("middle_room_submaps",
         e.middle_room_submaps ? std::to_string(*e.middle_room_submaps) : "");
    whole("submaps_across_storeys", static_cast<std::int64_t>(e.submaps_across_storeys));
    whole("wrong_closures", static_cast<std::int64_t>(e.wrong_closures));
    whole("fused_across_wrong_closures", static_cast<std::int64_t>(e.fused_across));
    whole("pairs_left_to_fuse", static_cast<std::int64_t>(e.overlapping_pairs));
    whole("pairs_in_doubt", static_cast<std::int64_t>(e.doubtful_pairs));
    real("trajectory_rms_m", e.trajectory_rms_m);
    real("mesh_within_5cm", e.mesh.within_5cm);
    real("mesh_within_10cm", e.mesh.within_10cm);
    real("mesh_within_25cm", e.mesh.within_25cm);
    real("perfect_within_5cm", e.returns.within_5cm);
    real("perfect_within_10cm", e.returns.within_10cm);
    real("perfect_within_25cm", e.returns.within_25cm);
    real("complete_10cm", e.complete_10cm);
    real("doubled_share", e.doubled_share);
    real("doubled_far_share", e.doubled_far_share);
    std::string failed;
    for (const Line& line : judge_lines(e)) {
      if (line.verdict.starts_with("FAIL")) failed += (failed.empty() ? "" : "; ") + line.what;
    }
    cell("failed", failed);
    cell("date", provenance.date);
    std::string machine = provenance.machine;
    std::replace(machine.begin(), machine.end(), ',', ';');
    cell("machine", machine);
    cell("commit", provenance.commit);
    rows += row + "\n";
  }
  return head + "\n" + rows;
}

}  // namespace cloister
