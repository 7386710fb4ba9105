#pragma once

#include <string>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// Parts of the report, each a piece of XHTML that ends with a newline. Lengths are capped: what
/// does not fit is counted and the file that has it is named.

/// Every final submap with its colour, what it was merged from, its extent and its memory.
[[nodiscard]] std::string submaps_table(const MissionRecord& record);

/// How many events of each kind there were, and the events themselves. When there are too many,
/// graph updates, drops and checks that decided nothing give way first.
[[nodiscard]] std::string decisions_table(const MissionRecord& record);

/// Percentiles of each stage's wall time and the CPU time of its thread.
[[nodiscard]] std::string timing_table(const MissionRecord& record);

/// Drops by cause, and further counters.
[[nodiscard]] std::string counts_tables(const MissionRecord& record);

/// The configuration in force, as `section.field` and value.
[[nodiscard]] std::string config_list(const Config& config);

}  // namespace cloister
