#include "firmware_interface/output/mission_output.hpp"

#include <array>
#include <functional>

#include "firmware_interface/files/atomic_file.hpp"
#include "firmware_interface/output/events_jsonl.hpp"
#include "firmware_interface/output/plan_svg.hpp"
#include "firmware_interface/output/report_html.hpp"
#include "firmware_interface/output/submaps_json.hpp"
#include "firmware_interface/output/summary_json.hpp"
#include "firmware_interface/output/timeline_csv.hpp"
#include "firmware_interface/output/trajectory_tum.hpp"

namespace cloister {

Result<void> write_mission_outputs(const MissionRecord& record, const std::filesystem::path& out) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) {
    return fail(ErrorKind::kResource, out.string() + ": cannot make the directory: " +
                                          error.message() + "; choose another or free it");
  }
  struct Output {
    const char* name;
    std::function<std::string()> text;
  };
  const std::array<Output, 7> outputs = {{
      {"submaps.json", [&] { return submaps_json(record.submaps); }},
      {"timeline.csv", [&] { return timeline_csv(record.timeline); }},
      {"events.jsonl", [&] { return events_jsonl(record.events); }},
      {"trajectory.tum", [&] { return trajectory_tum(record.path_M); }},
      {"plan.svg", [&] { return plan_svg(record); }},
      {"report.html", [&] { return report_html(record); }},
      {"summary.json", [&] { return summary_json(record); }},
  }};
  for (const Output& output : outputs) {
    if (auto written = write_file_atomically(out / output.name, output.text()); !written)
      return written;
  }
  return {};
}

}  // namespace cloister
