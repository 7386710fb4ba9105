#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/experiments/experiment.hpp"

namespace cloister {

/// One line of an experiment's table.
struct Line {
  std::string what;
  std::string ours;
  std::string baseline;  ///< empty where it was not measured
  std::string limit;     ///< empty where there is none
  /// "PASS" or "FAIL"; with a star where the limit is about a whole mission and this one was cut short; or empty
  std::string verdict;
};

/// The figures that are promised, each with its limit, and the others beside them.
[[nodiscard]] std::vector<Line> judge_lines(const Experiment& experiment);

/// A heading and the lines in columns, for people.
[[nodiscard]] std::string format_table(const Experiment& experiment,
                                       const std::vector<Line>& lines);

/// Which machine and which state of the tree a table is of.
struct Provenance {
  std::string date;
  std::string machine;
  std::string commit;
};

/// The whole results file: a header and a row for each experiment. A cell that was not measured is empty.
[[nodiscard]] std::string format_csv(const std::vector<Experiment>& experiments,
                                     const Provenance& provenance);

}  // namespace cloister
