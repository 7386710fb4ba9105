#include "bench/integration/bar_plot.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace cloister {
namespace {

constexpr double kWidth = 820;
constexpr double kLeft = 150, kRight = 650;
constexpr double kTop = 56, kBarHeight = 16, kBarStep = 22, kGroupGap = 14;

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

bool parse_positive(std::string_view cell, double& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size() && value > 0 &&
         std::isfinite(value);
}

/// Three significant digits, without zeros at the end.
std::string number(double value) {
  char buffer[32];
  const auto end =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::general, 3);
  std::string text(buffer, end.ptr);
  if (text.find('e') == std::string::npos) return text;
  return std::to_string(std::llround(value));
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return out;
}

/// Whole decades around all values, from left to right.
struct LogAxis {
  double first = 0, last = 1;

  explicit LogAxis(const std::vector<Bar>& bars) {
    double least = bars.front().median_ms, most = bars.front().p999_ms;
    for (const Bar& bar : bars) {
      least = std::min(least, bar.median_ms);
      most = std::max({most, bar.p999_ms, bar.median_ms});
    }
    // A bar's length should show even where it is the shortest of all.
    first = std::floor(std::log10(least) - 0.2);
    last = std::max(std::ceil(std::log10(most)), first + 1);
  }
  [[nodiscard]] double x(double ms) const {
    return kLeft + (kRight - kLeft) * (std::log10(ms) - first) / (last - first);
  }
};

void put_text(std::string& svg, double x, double y, std::string_view anchor, std::string_view text,
              std::string_view css = "") {
  svg += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" +
         std::string(anchor) + "\"" + (css.empty() ? "" : " class=\"" + std::string(css) + "\"") +
         ">" + escaped(text) + "</text>\n";
}

void put_rect(std::string& svg, double x, double y, double width, double height,
              std::string_view css) {
  svg += "<rect class=\"" + std::string(css) + "\" x=\"" + number(x) + "\" y=\"" + number(y) +
         "\" width=\"" + number(std::max(width, 1.0)) + "\" height=\"" + number(height) + "\"/>\n";
}

void put_bar(std::string& svg, const Bar& bar, double y, const LogAxis& axis) {
  const std::string css = bar.library.starts_with("cloister") ? "ours" : "peer";
  put_rect(svg, kLeft, y, axis.x(bar.median_ms) - kLeft, kBarHeight, css);
  const double x_end = axis.x(std::max(bar.p999_ms, bar.median_ms));
  put_rect(svg, axis.x(bar.median_ms), y + kBarHeight / 2 - 1, x_end - axis.x(bar.median_ms), 2,
           css);
  put_text(svg, kLeft - 6, y + 12, "end", bar.library);
  put_text(svg, x_end + 6, y + 12, "start",
           number(bar.median_ms) + " ms (" + number(bar.scans) + " scans)");
}

double put_group(std::string& svg, const std::vector<Bar>& bars, const std::string& mission,
                 double y, const LogAxis& axis) {
  put_text(svg, 6, y + 12, "start", mission, "mission");
  y += kBarStep;
  for (const Bar& bar : bars) {
    if (bar.mission != mission) continue;
    put_bar(svg, bar, y, axis);
    y += kBarStep;
  }
  return y + kGroupGap;
}

}  // namespace

Result<std::vector<Bar>> read_bars(std::string_view csv, std::string_view file_name) {
  constexpr std::array<std::string_view, 6> kColumns = {"mission", "library",   "machine",
                                                        "scans",   "median_ms", "p999_ms"};
  std::array<std::size_t, kColumns.size()> at{};
  std::vector<Bar> bars;
  for (int number = 1; !csv.empty(); ++number) {
    const std::size_t length = std::min(csv.find('\n'), csv.size());
    const std::vector<std::string_view> cells = split(csv.substr(0, length));
    csv.remove_prefix(std::min(length + 1, csv.size()));
    const std::string where = std::string(file_name) + ":" + std::to_string(number) + ": ";
    if (number == 1) {
      for (std::size_t k = 0; k < kColumns.size(); ++k) {
        const auto found = std::find(cells.begin(), cells.end(), kColumns[k]);
        if (found == cells.end()) {
          return fail(ErrorKind::kInput,
                      where + "no column " + std::string(kColumns[k]) + ": make the results again");
        }
        at[k] = static_cast<std::size_t>(found - cells.begin());
      }
      continue;
    }
    Bar bar;
    const bool is_whole = *std::max_element(at.begin(), at.end()) < cells.size() &&
                          parse_positive(cells[at[3]], bar.scans) &&
                          parse_positive(cells[at[4]], bar.median_ms) &&
                          parse_positive(cells[at[5]], bar.p999_ms);
    if (!is_whole) {
      return fail(ErrorKind::kInput, where + "scans and times must be positive: make it again");
    }
    bar.mission = cells[at[0]];
    bar.library = cells[at[1]];
    bar.machine = cells[at[2]];
    const auto same = std::find_if(bars.begin(), bars.end(), [&](const Bar& other) {
      return other.mission == bar.mission && other.library == bar.library;
    });
    if (same == bars.end()) {
      bars.push_back(std::move(bar));
    } else {
      *same = std::move(bar);
    }
  }
  return bars;
}

std::string bar_plot_svg(const std::vector<Bar>& bars) {
  if (bars.empty()) return {};
  const LogAxis axis(bars);
  std::vector<std::string> missions;
  for (const Bar& bar : bars) {
    if (std::find(missions.begin(), missions.end(), bar.mission) == missions.end()) {
      missions.push_back(bar.mission);
    }
  }
  const double bottom = kTop + kBarStep * static_cast<double>(bars.size() + missions.size()) +
                        kGroupGap * static_cast<double>(missions.size());
  std::string body;
  for (double decade = axis.first; decade <= axis.last; ++decade) {
    const double ms = std::pow(10.0, decade);
    put_rect(body, axis.x(ms), kTop - 8, 1, bottom - kTop + 8, "grid");
    put_text(body, axis.x(ms), kTop - 14, "middle", number(ms));
  }
  double y = kTop;
  for (const std::string& mission : missions) y = put_group(body, bars, mission, y, axis);
  put_text(body, 6, 18, "start",
           "CPU milliseconds per scan, one thread: median, thin line to the 99.9th percentile",
           "title");
  put_text(body, 6, bottom + 14, "start", bars.front().machine);
  const std::string width = number(kWidth), height = number(bottom + 24);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
         "\" viewBox=\"0 0 " + width + " " + height + "\" role=\"img\">\n" +
         "<style>svg{background:#fff}text{font:12px "
         "sans-serif;fill:#333}.title,.mission{font-weight:"
         "bold}.grid{fill:#ddd}.ours{fill:#1f77b4}.peer{fill:#999}</style>\n" +
         body + "</svg>\n";
}

}  // namespace cloister
