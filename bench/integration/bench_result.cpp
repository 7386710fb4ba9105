#include "bench/integration/bench_result.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>

namespace cloister {
namespace {

std::string fixed(double value, int decimals) {
  char buffer[64];
  const auto end =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::fixed, decimals);
  return end.ec == std::errc{} ? std::string(buffer, end.ptr) : std::string("inf");
}

/// A share in per cent, empty when nothing was asked.
std::string percent(const StateCounts& counts, VoxelState state) {
  return counts.total() == 0 ? "" : fixed(100 * counts.share(state), 3);
}

/// A text that needs no quotes in a CSV.
std::string plain(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '"' || c == '\n'; }, ' ');
  return text;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

/// Which cycles a table has.
const char* name_of(CycleKind kind) {
  switch (kind) {
    case CycleKind::kCore: return "core";
    case CycleKind::kReference: return "reference";
    case CycleKind::kNone: break;
  }
  return "";
}

std::string csv_line(const std::vector<Cell>& row, std::string Cell::*field) {
  std::string line;
  for (const Cell& cell : row) {
    if (!line.empty() || &cell != &row.front()) line += ',';
    line += plain(cell.*field);
  }
  return line;
}

/// What the scans after warming up spent in all.
struct AfterWarmUp {
  double scans = 0, page_faults = 0, allocations = 0;
};

AfterWarmUp sum_after(const std::vector<ScanCost>& costs, std::size_t warm_up) {
  AfterWarmUp sum;
  for (std::size_t i = warm_up; i < costs.size(); ++i) {
    sum.scans += 1;
    sum.page_faults += static_cast<double>(costs[i].spent.page_faults);
    sum.allocations += static_cast<double>(costs[i].spent.allocations);
  }
  return sum;
}

void add_costs(const BenchContext& context, const BenchResult& result, std::vector<Cell>& row) {
  const std::vector<double> ms = cpu_ms(result.costs);
  row.push_back({"scans", std::to_string(ms.size())});
  row.push_back({"median_ms", fixed(percentile(ms, 0.5), 3)});
  row.push_back({"p99_ms", fixed(percentile(ms, 0.99), 3)});
  row.push_back({"p999_ms", fixed(percentile(ms, 0.999), 3)});
  row.push_back({"max_ms", fixed(percentile(ms, 1), 3)});
  const double sum_ms = std::accumulate(ms.begin(), ms.end(), 0.0);
  row.push_back({"mean_ms", ms.empty() ? "" : fixed(sum_ms / static_cast<double>(ms.size()), 3)});
  row.push_back(
      {"times_faster_than_octomap", result.times_faster ? fixed(*result.times_faster, 1) : ""});

  double blocks = 0, cycles = 0;
  bool has_cycles = !result.costs.empty();
  for (const ScanCost& cost : result.costs) {
    blocks += static_cast<double>(cost.blocks_touched);
    has_cycles &= cost.spent.cycles.has_value();
    cycles += static_cast<double>(cost.spent.cycles.value_or(0));
  }
  const double voxels = blocks * kBlockVoxels;
  const double scans = std::max(1.0, static_cast<double>(ms.size()));
  row.push_back({"blocks_touched_per_scan", blocks == 0 ? "" : fixed(blocks / scans, 0)});
  row.push_back({"ns_per_touched_voxel", blocks == 0 ? "" : fixed(1e6 * sum_ms / voxels, 3)});
  row.push_back({"cycles_of", has_cycles ? name_of(context.cycle_kind) : ""});
  row.push_back({"cycles_per_scan", has_cycles ? fixed(cycles / scans, 0) : ""});
  row.push_back(
      {"cycles_per_touched_voxel", has_cycles && blocks > 0 ? fixed(cycles / voxels, 2) : ""});
  const AfterWarmUp rest = sum_after(result.costs, context.warm_up);
  row.push_back(
      {"page_faults_per_scan", rest.scans == 0 ? "" : fixed(rest.page_faults / rest.scans, 2)});
  row.push_back(
      {"allocations_per_scan", rest.scans == 0 ? "" : fixed(rest.allocations / rest.scans, 2)});
}

void add_memory(const BenchResult& result, std::vector<Cell>& row) {
  row.push_back({"map_bytes", std::to_string(result.map_bytes)});
  row.push_back({"observed_m3", fixed(result.observed_m3, 2)});
  row.push_back(
      {"kb_per_m3",
       result.observed_m3 == 0
           ? ""
           : fixed(1e-3 * static_cast<double>(result.map_bytes) / result.observed_m3, 3)});
}

void add_quality(const BenchResult& result, std::vector<Cell>& row) {
  const BeamQuality& beams = result.beams;
  row.push_back({"beam_points", std::to_string(beams.before_end.total())});
  row.push_back({"beam_free_pct", percent(beams.before_end, VoxelState::kFree)});
  row.push_back({"beam_unknown_pct", percent(beams.before_end, VoxelState::kUnknown)});
  row.push_back({"beam_occupied_pct", percent(beams.before_end, VoxelState::kOccupied)});
  row.push_back({"ends", std::to_string(beams.ends.total())});
  row.push_back({"end_occupied_pct", percent(beams.ends, VoxelState::kOccupied)});
  row.push_back({"end_unknown_pct", percent(beams.ends, VoxelState::kUnknown)});
  const char* const names[] = {"end_occupied_0.5_5m_pct", "end_occupied_5_15m_pct",
                               "end_occupied_15_30m_pct", "end_occupied_30_60m_pct"};
  for (std::size_t i = 0; i < beams.ends_by_range.size(); ++i) {
    row.push_back({names[i], percent(beams.ends_by_range[i], VoxelState::kOccupied)});
  }
  row.push_back({"ground_ends", std::to_string(beams.ground_ends.total())});
  row.push_back({"ground_occupied_pct", percent(beams.ground_ends, VoxelState::kOccupied)});
  row.push_back({"ground_unknown_pct", percent(beams.ground_ends, VoxelState::kUnknown)});

  const bool has_truth = result.truth.has_value();
  const TruthQuality truth = result.truth.value_or(TruthQuality{});
  const std::size_t free_known = truth.in_free_space.total() - truth.in_free_space.counts[0];
  row.push_back({"truly_free_known", has_truth ? std::to_string(free_known) : ""});
  row.push_back({"false_occupied_pct", has_truth ? fixed(100 * truth.false_occupied(), 3) : ""});
  row.push_back({"truly_solid", has_truth ? std::to_string(truth.in_solids.total()) : ""});
  row.push_back({"false_free_pct", has_truth ? fixed(100 * truth.false_free(), 3) : ""});
}

}  // namespace

BenchContext context_here() {
  BenchContext context;
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  context.date = text;
  context.machine = processor_name();
  return context;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<double> cpu_ms(const std::vector<ScanCost>& costs) {
  std::vector<double> ms;
  ms.reserve(costs.size());
  for (const ScanCost& cost : costs) ms.push_back(1e-6 * static_cast<double>(cost.spent.cpu_ns));
  return ms;
}

std::vector<Cell> cells_of(const BenchContext& context, const BenchResult& result) {
  std::vector<Cell> row = {{"date", context.date},
                           {"machine", context.machine},
                           {"commit", context.commit},
                           {"mission", context.mission},
                           {"library", result.library},
                           {"poses", context.poses},
                           {"voxel_m", fixed(context.voxel_m, 4)},
                           {"max_range_m", fixed(context.max_range_m, 1)}};
  add_costs(context, result, row);
  add_memory(result, row);
  add_quality(result, row);
  return row;
}

Result<void> append_csv(const std::filesystem::path& file,
                        const std::vector<std::vector<Cell>>& rows) {
  if (rows.empty()) return {};
  const std::string header = csv_line(rows.front(), &Cell::name);
  std::string found;
  {
    std::ifstream old(file);
    std::getline(old, found);
  }
  if (!found.empty() && found != header) {
    return fail(ErrorKind::kInput,
                file.string() + ":1: has other columns than these results: move it away");
  }
  std::ofstream stream(file, std::ios::app);
  if (found.empty()) stream << header << '\n';
  for (const auto& row : rows) stream << csv_line(row, &Cell::value) << '\n';
  stream.close();
  if (!stream)
    return fail(ErrorKind::kResource, file.string() + ": cannot be written: check the path");
  return {};
}

Result<void> write_scans_csv(const std::filesystem::path& file,
                             const std::vector<BenchResult>& results) {
  std::ofstream stream(file);
  stream << "library,scan,stamp_ns,cpu_ms,cycles,page_faults,allocations,blocks_touched\n";
  for (const BenchResult& result : results) {
    for (const ScanCost& cost : result.costs) {
      stream << plain(result.library) << ',' << cost.scan << ',' << cost.stamp_ns << ','
             << fixed(1e-6 * static_cast<double>(cost.spent.cpu_ns), 4) << ','
             << (cost.spent.cycles ? std::to_string(*cost.spent.cycles) : "") << ','
             << cost.spent.page_faults << ',' << cost.spent.allocations << ','
             << cost.blocks_touched << '\n';
    }
  }
  stream.close();
  if (!stream)
    return fail(ErrorKind::kResource, file.string() + ": cannot be written: check the path");
  return {};
}

void print_table(const std::vector<std::vector<Cell>>& rows) {
  if (rows.empty()) return;
  for (std::size_t i = 0; i < rows.front().size(); ++i) {
    std::printf("%-26s", rows.front()[i].name.c_str());
    for (const auto& row : rows) {
      std::printf("  %20s", row[i].value.empty() ? "-" : row[i].value.c_str());
    }
    std::printf("\n");
  }
}

}  // namespace cloister
