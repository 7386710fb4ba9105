#pragma once

#include <string>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The text of report.html: one page in XHTML-compatible HTML with its style and its pictures
/// inside, no script, and nothing fetched from anywhere. Figures first, then the plan of each
/// storey, the submaps, growth and timing, the decisions, losses and counters, and the
/// configuration. Meant for a screen of any width, light or dark, and for paper.
[[nodiscard]] std::string report_html(const MissionRecord& record);

}  // namespace cloister
