#include "firmware_interface/output/plan_svg.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "firmware_interface/output/page_text.hpp"
#include "firmware_interface/output/submap_colour.hpp"

namespace cloister {
namespace {

constexpr double kWidth = 1000;   // of a storey's drawing, SVG units
constexpr double kLegend = 64;    // below it, for the scale bar and the axes
constexpr double kFontSize = 22;  // in a picture of its own

// From M to a storey's drawing: y up becomes y down.
struct Paper {
  Eigen::Vector2d min_M, size_M;
  double scale = 1;  // units per metre
  double left = 0;   // of the drawing, where the place is higher than wide
  double height = 0;

  explicit Paper(const Plan& plan) : min_M(plan.min_M), size_M(plan.max_M - plan.min_M) {
    scale = kWidth / size_M.maxCoeff();
    left = 0.5 * (kWidth - scale * size_M.x());
    height = scale * size_M.y() + kLegend;
  }
  [[nodiscard]] double x(double x_M) const { return left + scale * (x_M - min_M.x()); }
  [[nodiscard]] double y(double y_M) const { return scale * (size_M.y() - (y_M - min_M.y())); }
};

// Layer cells as one path per submap, in units of a cell so that all numbers are short integers.
void put_layer(std::string& out, const MissionRecord& record, const PlanLayer& layer,
               const Paper& paper, double opacity) {
  // By owner: its path, and where the pen is.
  std::map<std::int32_t, std::pair<std::string, std::pair<int, int>>> paths;
  for (const PlanRectangle& r : merge_cells(layer)) {
    auto& [path, pen] = paths[r.owner];
    const std::pair<int, int> corner(r.column, -r.row);
    put(path, "m", corner.first - pen.first, " ", corner.second - pen.second, "h", r.width, "v-",
        r.height, "h-", r.width, "z");
    pen = corner;
  }
  put(out, "<g shape-rendering=\"crispEdges\" opacity=\"", opacity, "\" transform=\"translate(",
      paper.x(paper.min_M.x()), " ", paper.y(paper.min_M.y()), ") scale(",
      compact(paper.scale * layer.cell_m, 5), ")\">\n");
  for (const auto& [owner, path] : paths) {
    const SubmapId id = record.submaps[static_cast<std::size_t>(owner)].id;
    put(out, "<path fill=\"", hex_colour(submap_colour(id)), "\" d=\"", path.first, "\"/>\n");
  }
  out += "</g>\n";
}

void put_path(std::string& out, const StoreyPlan& storey, const Paper& paper) {
  std::string lines;
  for (const auto& piece : storey.path_M) {
    char command = 'M';
    for (const Eigen::Vector2d& p_M : piece) {
      put(lines, command, compact(paper.x(p_M.x()), 1), " ", compact(paper.y(p_M.y()), 1));
      command = 'L';
    }
  }
  if (!lines.empty()) put(out, "<path class=\"path\" d=\"", lines, "\"/>\n");
}

void put_end(std::string& out, const Eigen::Vector2d& at_M, const Paper& paper, bool is_start) {
  put(out, "<circle class=\"", is_start ? "start" : "end", "\" cx=\"", paper.x(at_M.x()),
      "\" cy=\"", paper.y(at_M.y()), "\" r=\"7\"><title>", is_start ? "start" : "end",
      " of the path</title></circle>\n");
}

void put_labels(std::string& out, const StoreyPlan& storey, const Paper& paper) {
  for (const StoreyPlan::Label& label : storey.labels) {
    put(out, "<text class=\"label\" x=\"", paper.x(label.at_M.x()), "\" y=\"",
        paper.y(label.at_M.y()), "\" dy=\".35em\">", label.id, "</text>\n");
  }
}

// The round length (1, 2 or 5 times a power of ten) closest to a fifth of the drawing from below.
double scale_bar_m(const Paper& paper) {
  const double target_m = 0.2 * kWidth / paper.scale;
  const double power = std::pow(10.0, std::floor(std::log10(target_m)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= target_m) return factor * power;
  }
  return power;
}

void put_legend(std::string& out, const Paper& paper) {
  const double length_m = scale_bar_m(paper);
  const double y = paper.height - 14;
  const double x = 64;
  const double end = x + length_m * paper.scale;
  put(out, "<path class=\"rule\" d=\"M4 ", y - 38, "V", y, "H42M-1 ", y - 31, "L4 ", y - 39, "L9 ",
      y - 31, "M35 ", y - 5, "L43 ", y, "L35 ", y + 5, "M", x, " ", y - 6, "V", y, "H", end, "V",
      y - 6, "\"/>\n");
  put(out, "<text class=\"mark\" x=\"14\" y=\"", y - 26,
      "\">y</text><text class=\"mark\" x=\"34\" y=\"", y - 9,
      "\">x</text><text class=\"mark\" x=\"", end + 10, "\" y=\"", y + 3, "\">",
      compact(length_m, 3), " m</text>\n");
}

void put_storey(std::string& out, const MissionRecord& record, const Plan& plan,
                std::size_t index) {
  const Paper paper(plan);
  const StoreyPlan& storey = plan.storeys[index];
  put_layer(out, record, storey.floor, paper, 0.3);
  put_layer(out, record, storey.walls, paper, 1.0);
  put_path(out, storey, paper);
  if (storey.start_M) put_end(out, *storey.start_M, paper, true);
  if (storey.end_M) put_end(out, *storey.end_M, paper, false);
  put_labels(out, storey, paper);
  put_legend(out, paper);
}

constexpr std::string_view kStyle = R"(<style>
text { font: 22px system-ui, "DejaVu Sans", sans-serif; fill: #4a525c }
.title { font-weight: 600; fill: #16191d }
.label { font-weight: 700; text-anchor: middle; fill: #16191d; stroke: #ffffff; stroke-width: 5px; paint-order: stroke; stroke-linejoin: round }
.path { fill: none; stroke: #16191d; stroke-width: 2px; stroke-opacity: .6; stroke-linejoin: round }
.rule { fill: none; stroke: #4a525c; stroke-width: 2px }
.start { fill: #ffffff; stroke: #16191d; stroke-width: 3px }
.end { fill: #16191d }
.paper { fill: #ffffff }
@media (prefers-color-scheme: dark) {
text { fill: #a6b0bb } .title { fill: #e7eaee }
.label { fill: #ffffff; stroke: #111417 }
.path, .start { stroke: #e7eaee } .start, .paper { fill: #111417 } .end { fill: #e7eaee } .rule { stroke: #a6b0bb }
}
</style>
)";

}  // namespace

std::string storey_title(const Plan& plan, std::size_t storey) {
  if (plan.storeys.size() == 1) return "Plan";
  return "Floor at " + compact(plan.storeys[storey].floor_z_m, 1) + " m";
}

std::string storey_svg(const MissionRecord& record, const Plan& plan, std::size_t storey) {
  std::string out;
  put(out, "<svg viewBox=\"0 0 ", kWidth, " ", Paper(plan).height, "\" role=\"img\" aria-label=\"",
      storey_title(plan, storey), ", coloured by submap\">\n");
  put_storey(out, record, plan, storey);
  out += "</svg>\n";
  return out;
}

std::string plan_svg(const MissionRecord& record) {
  constexpr double kGap = 40;
  const Plan plan = make_plan(record);
  const auto count = static_cast<double>(plan.storeys.size());
  const double width = plan.is_empty() ? kWidth : count * kWidth + (count + 1) * kGap;
  const double height = plan.is_empty() ? 3 * kGap : Paper(plan).height + 2.5 * kGap;
  std::string out;
  put(out, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ", width, " ", height,
      "\" width=\"", width, "\" height=\"", height, "\">\n", "<title>", escape_xml(record.mission),
      ": plan coloured by submap</title>\n", kStyle, "<rect class=\"paper\" width=\"", width,
      "\" height=\"", height, "\"/>\n");
  if (plan.is_empty()) {
    put(out, "<text x=\"", kGap, "\" y=\"", 2 * kGap, "\">Nothing was mapped.</text>\n</svg>\n");
    return out;
  }
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    const double left = kGap + static_cast<double>(s) * (kWidth + kGap);
    put(out, "<g transform=\"translate(", left, " ", 1.5 * kGap, ")\">\n");
    if (plan.storeys.size() > 1) {
      put(out, "<text class=\"title\" x=\"0\" y=\"-", kFontSize, "\">", storey_title(plan, s),
          "</text>\n");
    }
    put_storey(out, record, plan, s);
    out += "</g>\n";
  }
  out += "</svg>\n";
  return out;
}

}  // namespace cloister
