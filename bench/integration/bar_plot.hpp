#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mapping/core/result.hpp"

namespace cloister {

/// What one bar of the plot shows.
struct Bar {
  std::string mission;
  std::string library;
  std::string machine;
  double scans = 0;
  double median_ms = 0;
  double p999_ms = 0;
};

/// Reads the rows of a results CSV, columns found by name, in order; of rows with the same mission and library the last
/// counts. Errors: kInput with file:line when a column is missing, a row is too short or a time is not positive
[[nodiscard]] Result<std::vector<Bar>> read_bars(std::string_view csv, std::string_view file_name);

/// CPU time of a scan as horizontal bars over a logarithmic axis, grouped by mission: median, and a thin line up to
/// the 99.9th percentile. A whole SVG document.
[[nodiscard]] std::string bar_plot_svg(const std::vector<Bar>& bars);

}  // namespace cloister
