#include "firmware_interface/output/report_html.hpp"

#include <cstdio>

#include "firmware_interface/output/chart_svg.hpp"
#include "firmware_interface/output/page_text.hpp"
#include "firmware_interface/output/plan_svg.hpp"
#include "firmware_interface/output/report_style.hpp"
#include "firmware_interface/output/report_tables.hpp"

namespace cloister {
namespace {

std::string counted(std::int64_t count, std::string_view singular, std::string_view plural) {
  return grouped(count) + " " + std::string(count == 1 ? singular : plural);
}

// The mission in a sentence or two, for who reads nothing else.
std::string lede(const MissionRecord& r) {
  std::string out;
  put(out, "In ", clock_text(r.duration_s), " min and ", readable(r.travel_m), " m of travel, ",
      counted(r.scans_integrated, "scan", "scans"), " became ",
      counted(r.submaps_spawned, "submap", "submaps"), "; ",
      r.submaps_fused == 0 ? "none" : grouped(r.submaps_fused),
      r.submaps_fused == 1 ? " was" : " were", " fused into another, ", grouped(r.submaps_final),
      r.submaps_final == 1 ? " remains." : " remain.");
  if (r.config.baseline)
    out += " Baseline: submaps by distance, fusion at loop closures only, no uncertainty check.";
  return out;
}

void put_figure(std::string& out, std::string_view name, std::string_view value,
                std::string_view more) {
  put(out, "<div><dt>", name, "</dt><dd class=\"figure\">", value, "</dd><dd class=\"more\">", more,
      "</dd></div>\n");
}

std::string with_unit(double value, std::string_view unit) {
  return readable(value) + " <small>" + std::string(unit) + "</small>";
}

std::string size_with_unit(std::int64_t bytes) {
  const std::string text = byte_size(bytes);
  const std::size_t space = text.find(' ');
  return text.substr(0, space) + " <small>" + text.substr(space + 1) + "</small>";
}

void put_key_figures(std::string& out, const MissionRecord& r) {
  std::vector<float> latency_ms;
  for (const TimelineRow& row : r.timeline) latency_ms.push_back(row.latency_ms);
  const TimingSummary latency = summarise(std::move(latency_ms));
  const auto text = [](auto... pieces) {
    std::string joined;
    put(joined, pieces...);
    return joined;
  };
  out += "<dl class=\"keys\">\n";
  put_figure(
      out, "Submaps", grouped(r.submaps_final),
      text("peak ", grouped(r.submaps_peak), " of ", grouped(r.submaps_spawned), " spawned"));
  put_figure(out, "Observed", with_unit(r.observed_m3, "m³"),
             text("voxels of ", compact(r.config.voxel.voxel_size_m * 100), " cm"));
  put_figure(out, "Map memory", size_with_unit(r.map_bytes_final),
             text("peak ", byte_size(r.map_bytes_peak), ", budget ", byte_size(r.budget_bytes)));
  put_figure(out, "Scans integrated", grouped(r.scans_integrated),
             text(grouped(r.scans_dropped), " dropped of ", grouped(r.scans_read), " read"));
  put_figure(out, "Latency p99", with_unit(latency.p99, "ms"),
             text("p50 ", readable(latency.p50), ", max ", readable(latency.max)));
  put_figure(out, "Travel", with_unit(r.travel_m, "m"),
             text("in ", clock_text(r.duration_s), " min"));
  put_figure(out, "Fusions", grouped(r.fusions_accepted),
             text("refused: ", grouped(r.fusions_rejected_by_uncertainty), " by uncertainty, ",
                  grouped(r.fusions_rejected_by_overlap), " by overlap"));
  put_figure(out, "Returns",
             readable(static_cast<double>(r.returns_integrated) * 1e-6) + " <small>million</small>",
             text("process memory ", byte_size(r.rss_peak_bytes)));
  out += "</dl>\n";
}

void put_notes(std::string& out, const MissionRecord& r) {
  constexpr std::size_t kMaxWarnings = 100;
  if (r.interrupted) {
    out +=
        "<div class=\"note-box\"><p>Interrupted: everything here is complete up to that "
        "moment.</p></div>\n";
  }
  if (r.warnings.empty()) return;
  put(out, "<div class=\"note-box\"><p>",
      counted(static_cast<std::int64_t>(r.warnings.size()), "warning", "warnings"), "</p><ul>\n");
  for (std::size_t i = 0; i < std::min(r.warnings.size(), kMaxWarnings); ++i)
    put(out, "<li>", escape_xml(r.warnings[i]), "</li>\n");
  if (r.warnings.size() > kMaxWarnings)
    put(out, "<li>", r.warnings.size() - kMaxWarnings, " more in <code>summary.json</code></li>\n");
  out += "</ul></div>\n";
}

void put_plans(std::string& out, const MissionRecord& r) {
  const Plan plan = make_plan(r);
  if (plan.is_empty()) {
    out += "<h2>Plan</h2>\n<p class=\"soft\">Nothing was mapped.</p>\n";
    return;
  }
  const bool is_single = plan.storeys.size() == 1;
  out += is_single ? "<h2>Plan</h2>\n" : "<h2>Plan of each storey</h2>\n";
  out +=
      "<p class=\"soft small\">One colour a submap, its number at its middle: pale what is floor, "
      "solid what stands 0.3 to 2 m "
      "above it. The line is the path of the sensor, from the open to the filled dot.</p>\n";
  if (!is_single) out += "<div class=\"pair\">\n";
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    out += "<figure class=\"plan\">\n";
    if (!is_single) put(out, "<h3>", storey_title(plan, s), "</h3>\n");
    put(out, storey_svg(r, plan, s), "</figure>\n");
  }
  if (!is_single) out += "</div>\n";
}

void put_charts(std::string& out, const MissionRecord& r) {
  out += "<h2>Growth and timing</h2>\n";
  const std::string growth = growth_chart_svg(r);
  const std::string timing = timing_chart_svg(r);
  if (growth.empty()) out += "<p class=\"soft\">No scan was integrated.</p>\n";
  out += "<div class=\"pair\">\n";
  for (const std::string* chart : {&growth, &timing}) {
    if (!chart->empty()) put(out, "<figure class=\"chart\">\n", *chart, "</figure>\n");
  }
  out += "</div>\n";
}

}  // namespace

std::string report_html(const MissionRecord& record) {
  const std::string title = record.mission.empty() ? "Mission" : escape_xml(record.mission);
  std::string out;
  put(out,
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
      "charset=\"utf-8\"/>\n",
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>", title,
      " · Cloister</title>\n<style>", kReportStyle,
      "</style>\n</head>\n<body>\n<main>\n<p class=\"over\">Cloister mission report</p>\n<h1>",
      title, "</h1>\n<p class=\"lede\">", lede(record), "</p>\n");
  put_key_figures(out, record);
  put_notes(out, record);
  put_plans(out, record);
  put(out, "<h2>Submaps</h2>\n", submaps_table(record));
  put_charts(out, record);
  put(out, timing_table(record));
  put(out, "<h2>Decisions</h2>\n", decisions_table(record));
  put(out, "<h2>Losses and counters</h2>\n", counts_tables(record));
  put(out, "<h2>Configuration</h2>\n", config_list(record.config));
  char hash[19];
  std::snprintf(hash, sizeof(hash), "0x%016llx", static_cast<unsigned long long>(record.map_hash));
  put(out, "<footer>Cloister " CLOISTER_VERSION " · map hash <span class=\"mono\">", hash,
      "</span> · all lengths in metres, MB are 10⁶ bytes</footer>\n</main>\n</body>\n</html>\n");
  return out;
}

}  // namespace cloister
