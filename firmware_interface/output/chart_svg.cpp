#include "firmware_interface/output/chart_svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "firmware_interface/output/page_text.hpp"

namespace cloister {
namespace {

constexpr double kWidth = 520, kHeight = 336;
constexpr double kLeft = 50, kRight = 508;
constexpr int kIntervals = 220;

// One of the two panels of a chart: values from 0 to `top` between two heights of the drawing.
struct Panel {
  double y_top = 0, y_bottom = 0;
  double top = 1;

  [[nodiscard]] double y(double value) const {
    return y_bottom - (y_bottom - y_top) * std::clamp(value / top, 0.0, 1.0);
  }
};

constexpr double kUpperTop = 34, kUpperBottom = 146, kLowerTop = 196, kLowerBottom = 308;

// 1, 2 or 5 times a power of ten, so that about `count` steps make up the range;
// whole numbers if asked.
double tick_step(double range, int count, bool whole = false) {
  const double raw = std::max(range / count, 1e-9);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= raw * 0.999) step = factor * power;
  }
  return whole ? std::max(1.0, step) : step;
}

std::string tick_text(double value) {
  return value < 1000 ? compact(value, 4) : grouped(std::llround(value));
}

double time_step(double range_s) {
  constexpr std::array<double, 16> kSteps_s = {0.1, 0.2, 0.5, 1,   2,   5,    10,   20,
                                               30,  60,  120, 300, 600, 1200, 1800, 3600};
  for (const double step_s : kSteps_s) {
    if (range_s / step_s <= 6) return step_s;
  }
  return 3600 * std::ceil(range_s / (6 * 3600));
}

void put_text(std::string& out, std::string_view css, double x, double y, std::string_view text) {
  put(out, "<text class=\"", css, "\" x=\"", x, "\" y=\"", y, "\">", text, "</text>\n");
}

void put_line(std::string& out, std::string_view css, double x0, double y0, double x1, double y1) {
  put(out, "<path class=\"", css, "\" d=\"M", x0, " ", y0, "L", x1, " ", y1, "\"/>\n");
}

void open_svg(std::string& out, std::string_view label) {
  put(out, "<svg viewBox=\"0 0 ", kWidth, " ", kHeight, "\" role=\"img\" aria-label=\"", label,
      "\">\n");
}

void put_value_axis(std::string& out, const Panel& panel, double step, double shown_per_value) {
  for (double value = 0; value <= panel.top * 1.0001; value += step) {
    const double y = panel.y(value);
    put_line(out, value == 0 ? "axis" : "grid", kLeft, y, kRight, y);
    put_text(out, "right", kLeft - 6, y + 4, tick_text(value * shown_per_value));
  }
}

// ---- growth over time ----

struct TimeAxis {
  double range_s = 1;
  [[nodiscard]] double x(double t_s) const { return kLeft + (kRight - kLeft) * t_s / range_s; }
};

std::string step_line(const std::vector<Sample>& samples, const TimeAxis& axis,
                      const Panel& panel) {
  std::string d;
  for (const Sample& s : samples) {
    if (d.empty())
      put(d, "M", axis.x(s.t), " ", panel.y(s.value));
    else
      put(d, "H", axis.x(s.t), "V", panel.y(s.value));
  }
  if (samples.size() == 1) d += "h3";
  return d;
}

void put_series(std::string& out, std::string_view css, const std::vector<Sample>& samples,
                const TimeAxis& axis, const Panel& panel) {
  const std::vector<Sample> thinned = thin(samples, kIntervals);
  const std::string d = step_line(thinned, axis, panel);
  put(out, "<path class=\"area ", css, "\" d=\"", d, "V", panel.y_bottom, "H",
      axis.x(thinned.front().t), "z\"/>\n");
  put(out, "<path class=\"line ", css, "\" d=\"", d, "\"/>\n");
}

void put_time_axis(std::string& out, const TimeAxis& axis) {
  const double step_s = time_step(axis.range_s);
  for (int k = 0; k * step_s <= axis.range_s * 1.0001; ++k) {
    const double x = axis.x(k * step_s);
    put_line(out, "grid", x, kUpperTop, x, kUpperBottom);
    put_line(out, "grid", x, kLowerTop, x, kLowerBottom);
    const std::string text =
        axis.range_s >= 90 ? clock_text(k * step_s) : compact(k * step_s, 1) + " s";
    put_text(out, "middle", std::min(x, kRight - 14), kLowerBottom + 20, text);
  }
}

// ---- timing histograms ----

// A logarithmic axis over whole bins that holds every duration:
// some two dozen bins, however wide the range.
struct LogAxis {
  int bins_per_decade = 10;
  int first = 0, last = 0;  // bins; bin k spans 10^(k / bins_per_decade) ms and the next

  LogAxis(double least_ms, double most_ms) {
    const double decades = std::log10(clamped(most_ms)) - std::log10(clamped(least_ms));
    bins_per_decade = static_cast<int>(std::clamp(24.0 / std::max(decades, 0.01), 5.0, 60.0));
    first = bin(least_ms) - 1;
    last = bin(most_ms) + 1;
  }
  static double clamped(double ms) { return std::clamp(ms, 1e-4, 1e9); }
  [[nodiscard]] double position(double ms) const {
    return bins_per_decade * std::log10(clamped(ms));
  }
  [[nodiscard]] int bin(double ms) const { return static_cast<int>(std::floor(position(ms))); }
  [[nodiscard]] double x(double ms) const { return x_of_bin(position(ms)); }
  [[nodiscard]] double x_of_bin(double k) const {
    return kLeft + (kRight - kLeft) * std::clamp((k - first) / (last + 1 - first), 0.0, 1.0);
  }
};

// Round durations, as many as there is room for: the rounder ones have their place first.
void put_log_axis(std::string& out, const LogAxis& axis) {
  constexpr double kRoom = 56;
  std::vector<double> taken;
  for (const std::initializer_list<double> factors :
       {std::initializer_list<double>{1}, {5}, {2}, {3, 4, 6, 8}, {1.5, 2.5, 7, 9}}) {
    for (int decade = -4; decade < 9; ++decade) {
      for (const double factor : factors) {
        const double ms = factor * std::pow(10.0, decade);
        const double k = axis.position(ms);
        const double x = axis.x(ms);
        if (k < axis.first || k > axis.last + 1 || x > kRight - 18) continue;
        if (std::any_of(taken.begin(), taken.end(),
                        [&](double other) { return std::abs(x - other) < kRoom; }))
          continue;
        taken.push_back(x);
        put_line(out, "grid", x, kUpperTop, x, kUpperBottom);
        put_line(out, "grid", x, kLowerTop, x, kLowerBottom);
        put_text(out, "middle", x, kLowerBottom + 20, tick_text(ms) + " ms");
      }
    }
  }
}

void put_percentile(std::string& out, const LogAxis& axis, const Panel& panel,
                    std::string_view name, double ms, bool name_on_left) {
  const double x = axis.x(ms);
  put_line(out, "mark", x, panel.y_top, x, panel.y_bottom);
  name_on_left = name_on_left || x > kRight - 26;
  put_text(out, name_on_left ? "right" : "left", x + (name_on_left ? -4 : 4), panel.y_top + 9,
           name);
}

void put_histogram(std::string& out, std::string_view name, std::string_view css,
                   const std::vector<float>& durations_ms, const LogAxis& axis, Panel panel) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(axis.last - axis.first) + 1, 0);
  for (const float ms : durations_ms) ++counts[static_cast<std::size_t>(axis.bin(ms) - axis.first)];
  // The names of the marks need room above the bars.
  panel.top = 1.2 * static_cast<double>(*std::max_element(counts.begin(), counts.end()));
  put_value_axis(out, panel, tick_step(panel.top, 3, true), 1.0);
  std::string bars;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    const double x0 = axis.x_of_bin(axis.first + static_cast<double>(k)) + 0.5;
    const double x1 = axis.x_of_bin(axis.first + static_cast<double>(k) + 1) - 0.5;
    const double y = std::min(panel.y(static_cast<double>(counts[k])), panel.y_bottom - 1.5);
    put(bars, "M", x0, " ", panel.y_bottom, "V", y, "H", x1, "V", panel.y_bottom, "z");
  }
  put(out, "<path class=\"bar ", css, "\" d=\"", bars, "\"/>\n");
  const TimingSummary timing = summarise(durations_ms);
  put_percentile(out, axis, panel, "p50", timing.p50, true);
  put_percentile(out, axis, panel, "p99", timing.p99, false);
  std::string title(name);
  put(title, " <tspan class=\"note\">p50 ", readable(timing.p50), " · p99 ", readable(timing.p99),
      " · max ", readable(timing.max), " ms</tspan>");
  put_text(out, "head", 0, panel.y_top - 12, title);
}

std::vector<float> finite_durations(const MissionRecord& record, float TimelineRow::*duration_ms) {
  std::vector<float> durations_ms;
  for (const TimelineRow& row : record.timeline) {
    if (std::isfinite(row.*duration_ms)) durations_ms.push_back(row.*duration_ms);
  }
  return durations_ms;
}

}  // namespace

std::vector<Sample> thin(const std::vector<Sample>& samples, int intervals) {
  if (samples.size() <= static_cast<std::size_t>(4 * intervals)) return samples;
  const double begin = samples.front().t;
  const double span = std::max(samples.back().t - begin, 1e-9);
  const auto interval = [&](const Sample& s) {
    return std::min(intervals - 1, static_cast<int>((s.t - begin) / span * intervals));
  };
  const auto by_value = [](const Sample& a, const Sample& b) { return a.value < b.value; };
  std::vector<Sample> thinned;
  for (auto first = samples.begin(); first != samples.end();) {
    const auto end = std::find_if(first, samples.end(),
                                  [&](const Sample& s) { return interval(s) != interval(*first); });
    auto [least, most] = std::minmax_element(first, end, by_value);
    std::array kept = {first, least, most, std::prev(end)};
    std::sort(kept.begin(), kept.end());
    const auto last_kept = std::unique(kept.begin(), kept.end());
    std::transform(kept.begin(), last_kept, std::back_inserter(thinned),
                   [](auto it) { return *it; });
    first = end;
  }
  return thinned;
}

std::string growth_chart_svg(const MissionRecord& record) {
  if (record.timeline.empty()) return {};
  std::vector<Sample> memory, submaps;
  double t_s = 0;
  for (const TimelineRow& row : record.timeline) {
    t_s = std::max(t_s, (row.stamp - record.timeline.front().stamp).seconds());
    memory.push_back({t_s, static_cast<double>(row.map_bytes)});
    submaps.push_back({t_s, static_cast<double>(row.submaps)});
  }
  const auto most = [](const std::vector<Sample>& samples) {
    double value = 0;
    for (const Sample& s : samples) value = std::max(value, s.value);
    return value;
  };
  const TimeAxis axis{std::max(t_s, 1e-3)};
  const double peak_bytes = most(memory);
  const auto budget_bytes = static_cast<double>(record.budget_bytes);
  const bool budget_is_near = budget_bytes > 0 && peak_bytes > 0.4 * budget_bytes;
  const bool in_gigabytes = std::max(peak_bytes, budget_is_near ? budget_bytes : 0) >= 2e9;
  const double unit_bytes = in_gigabytes ? 1e9 : 1e6;

  Panel upper{kUpperTop, kUpperBottom,
              std::max(1.08 * peak_bytes, budget_is_near ? 1.04 * budget_bytes : 0)};
  upper.top = std::max(upper.top, 1e4);
  const Panel lower{kLowerTop, kLowerBottom, std::max(1.15 * most(submaps), 2.0)};

  std::string out;
  open_svg(out, "Map memory and number of submaps over time");
  put_time_axis(out, axis);
  put_value_axis(out, upper, tick_step(upper.top / unit_bytes, 4) * unit_bytes, 1.0 / unit_bytes);
  put_series(out, "one", memory, axis, upper);
  if (budget_is_near) {
    put_line(out, "limit", kLeft, upper.y(budget_bytes), kRight, upper.y(budget_bytes));
    put_text(out, "right warn", kRight, upper.y(budget_bytes) + 14, "budget");
  }
  std::string title = "Map memory, ";
  put(title, in_gigabytes ? "GB" : "MB", " <tspan class=\"note\">peak ",
      byte_size(record.map_bytes_peak));
  if (budget_bytes > 0) put(title, " of ", byte_size(record.budget_bytes));
  title += "</tspan>";
  put_text(out, "head", 0, kUpperTop - 12, title);

  put_value_axis(out, lower, tick_step(lower.top, 4, true), 1.0);
  put_series(out, "two", submaps, axis, lower);
  title = "Submaps";
  put(title, " <tspan class=\"note\">", grouped(record.submaps_spawned), " spawned · ",
      grouped(record.submaps_fused), " fused · peak ", grouped(record.submaps_peak), "</tspan>");
  put_text(out, "head", 0, kLowerTop - 12, title);
  out += "</svg>\n";
  return out;
}

std::string timing_chart_svg(const MissionRecord& record) {
  const std::vector<float> integrate_ms = finite_durations(record, &TimelineRow::integrate_ms);
  const std::vector<float> latency_ms = finite_durations(record, &TimelineRow::latency_ms);
  if (integrate_ms.empty() || latency_ms.empty()) return {};
  const auto [least_a, most_a] = std::minmax_element(integrate_ms.begin(), integrate_ms.end());
  const auto [least_b, most_b] = std::minmax_element(latency_ms.begin(), latency_ms.end());
  const LogAxis axis(std::min(*least_a, *least_b), std::max(*most_a, *most_b));

  std::string out;
  open_svg(out, "Histograms of integration time and latency");
  put_log_axis(out, axis);
  put_histogram(out, "Integration, scans", "one", integrate_ms, axis, {kUpperTop, kUpperBottom, 1});
  put_histogram(out, "Latency, scans", "two", latency_ms, axis, {kLowerTop, kLowerBottom, 1});
  out += "</svg>\n";
  return out;
}

}  // namespace cloister
