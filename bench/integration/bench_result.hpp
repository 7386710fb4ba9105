#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/integration/map_quality.hpp"
#include "bench/integration/thread_meter.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// One scan's cost.
struct ScanCost {
  std::uint64_t scan = 0;  ///< its number in the mission
  std::int64_t stamp_ns = 0;
  Spent spent;
  std::size_t blocks_touched = 0;
};

/// What a run of one map over a sequence of scans gave: one row of the table.
struct BenchResult {
  std::string library;
  std::vector<ScanCost> costs;  ///< of the integrated scans in order
  std::size_t map_bytes = 0;
  double observed_m3 = 0;
  BeamQuality beams;
  std::optional<TruthQuality> truth;
  /// Median of the peer over median of this, on the same scans.
  std::optional<double> times_faster;
};

/// What was measured where.
struct BenchContext {
  std::string date;     ///< UTC, ISO 8601
  std::string machine;  ///< the processor's name
  std::string commit;
  std::string mission;
  std::string poses;
  double voxel_m = 0;
  double max_range_m = 0;
  std::size_t warm_up = 0;  ///< scans after which faults and allocations count
  CycleKind cycle_kind = CycleKind::kNone;
};

/// Date and machine of now and here.
[[nodiscard]] BenchContext context_here();

/// Nearest-rank percentile of unsorted values, 0 for none. @param share 0 to 1; 0.5 is the median, 1 the maximum
[[nodiscard]] double percentile(std::vector<double> values, double share);
/// CPU milliseconds of every scan.
[[nodiscard]] std::vector<double> cpu_ms(const std::vector<ScanCost>& costs);

/// One column of the table: a name with its unit, and the value as text, empty where it was not measured.
struct Cell {
  std::string name;
  std::string value;
};
[[nodiscard]] std::vector<Cell> cells_of(const BenchContext& context, const BenchResult& result);

/// Appends rows to a CSV; a new file begins with the header. A file with another header is refused.
/// Errors: kInput for another header; kResource when the file cannot be written
[[nodiscard]] Result<void> append_csv(const std::filesystem::path& file,
                                      const std::vector<std::vector<Cell>>& rows);
/// Writes one row per integrated scan of every result. Errors: kResource
[[nodiscard]] Result<void> write_scans_csv(const std::filesystem::path& file,
                                           const std::vector<BenchResult>& results);

/// Prints the rows as columns side by side, the names at the left.
void print_table(const std::vector<std::vector<Cell>>& rows);

}  // namespace cloister
