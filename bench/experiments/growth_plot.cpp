#include "bench/experiments/growth_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace cloister {

namespace {

constexpr double kWidth = 720, kHeight = 460;
constexpr double kLeft = 62, kRight = 700;
constexpr double kPanelHeight = 170;
constexpr double kUpperTop = 40, kLowerTop = 250;
constexpr std::size_t kIntervals = 300;

struct Point {
  double minutes = 0.0;
  double value = 0.0;
};

std::string number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.6g", value);
  return buffer;
}

std::string pixel(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.1f", value);
  return buffer;
}

/// The least and the most of each interval, in their order.
std::vector<Point> thin_out(const std::vector<Point>& points) {
  if (points.size() <= 2 * kIntervals) return points;
  std::vector<Point> kept;
  for (std::size_t n = 0; n < kIntervals; ++n) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(n * points.size() / kIntervals);
    const auto end =
        points.begin() + static_cast<std::ptrdiff_t>((n + 1) * points.size() / kIntervals);
    const auto [least, most] = std::minmax_element(
        begin, end, [](const Point& a, const Point& b) { return a.value < b.value; });
    kept.push_back(*std::min(least, most));
    kept.push_back(*std::max(least, most));
  }
  kept.push_back(points.back());
  return kept;
}

/// A step between axis marks that people like, for about five of them.
double mark_step(double span) {
  const double raw = std::max(span, 1e-9) / 5.0;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= raw) return factor * decade;
  }
  return 10.0 * decade;
}

/// One chart: values of ours and of the baseline over minutes.
class Panel {
 public:
  Panel(double top, double minutes, double most)
      : top_(top), minutes_(std::max(minutes, 1e-6)), most_(std::max(most, 1e-6)) {}

  void draw_axes(const std::string& title, bool is_lowest, std::string* svg) const {
    text(kLeft, top_ - 8, "start", title, svg);
    for (double value = 0.0; value <= most_; value += mark_step(most_)) {
      line(kLeft, y(value), kRight, y(value), "grid", svg);
      text(kLeft - 6, y(value) + 4, "end", number(value), svg);
    }
    if (!is_lowest) return;
    for (double at = 0.0; at <= minutes_; at += mark_step(minutes_))
      text(x(at), top_ + kPanelHeight + 16, "middle", number(at), svg);
    text(kRight, top_ + kPanelHeight + 32, "end", "minutes", svg);
  }

  void draw_mark(double at_minutes, std::string* svg) const {
    line(x(at_minutes), top_, x(at_minutes), top_ + kPanelHeight, "round", svg);
  }

  void draw_series(const std::vector<Point>& points, const char* kind, std::string* svg) const {
    *svg += "<polyline class=\"" + std::string(kind) + "\" points=\"";
    for (const Point& point : thin_out(points))
      *svg += pixel(x(point.minutes)) + "," + pixel(y(point.value)) + " ";
    *svg += "\"/>\n";
  }

 private:
  static void line(double x0, double y0, double x1, double y1, const char* kind, std::string* svg) {
    *svg += "<line class=\"" + std::string(kind) + "\" x1=\"" + pixel(x0) + "\" y1=\"" + pixel(y0) +
            "\" x2=\"" + pixel(x1) + "\" y2=\"" + pixel(y1) + "\"/>\n";
  }
  static void text(double x0, double y0, const char* anchor, const std::string& words,
                   std::string* svg) {
    *svg += "<text x=\"" + pixel(x0) + "\" y=\"" + pixel(y0) + "\" text-anchor=\"" + anchor +
            "\">" + words + "</text>\n";
  }
  [[nodiscard]] double x(double at) const { return kLeft + (kRight - kLeft) * at / minutes_; }
  [[nodiscard]] double y(double value) const { return top_ + kPanelHeight * (1.0 - value / most_); }

  double top_, minutes_, most_;
};

}  // namespace

std::string growth_plot_svg(const Experiment& experiment) {
  const ReplayFigures* const replays[] = {&experiment.baseline, &experiment.ours};
  constexpr std::array kKinds = {"baseline", "ours"};
  if (experiment.ours.growth.empty()) return {};
  const SensorTime start = experiment.ours.growth.front().stamp;
  const auto minutes_of = [&](SensorTime stamp) { return (stamp - start).seconds() / 60.0; };
  std::array<std::vector<Point>, 2> megabytes, submaps;
  double minutes = 0.0, most_megabytes = 0.0, most_submaps = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    for (const MapSize& size : replays[k]->growth) {
      const double at = minutes_of(size.stamp);
      megabytes[k].push_back({at, static_cast<double>(size.bytes) * 1e-6});
      submaps[k].push_back({at, static_cast<double>(size.submaps)});
      minutes = std::max(minutes, at);
      most_megabytes = std::max(most_megabytes, megabytes[k].back().value);
      most_submaps = std::max(most_submaps, submaps[k].back().value);
    }
  }
  std::string body;
  for (const bool is_lowest : {false, true}) {
    const Panel panel(is_lowest ? kLowerTop : kUpperTop, minutes,
                      is_lowest ? most_submaps : most_megabytes);
    panel.draw_axes(is_lowest ? "submaps" : "map, MB", is_lowest, &body);
    for (const SensorTime end : experiment.round_ends) panel.draw_mark(minutes_of(end), &body);
    for (std::size_t k = 0; k < 2; ++k)
      panel.draw_series(is_lowest ? submaps[k] : megabytes[k], kKinds[k], &body);
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(kWidth) + "\" height=\"" +
         number(kHeight) + "\" viewBox=\"0 0 " + number(kWidth) + " " + number(kHeight) +
         "\" role=\"img\">\n<style>text{font:12px sans-serif;fill:#333}"
         "polyline{fill:none;stroke-width:1.6}.ours{stroke:#1f77b4;fill:none}.baseline{stroke:"
         "#d62728;fill:none}.grid{stroke:#ddd}.round{stroke:#999;stroke-dasharray:3 3}.ours-name"
         "{fill:#1f77b4;font-weight:bold}.baseline-name{fill:#d62728;font-weight:bold}</style>\n"
         "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
         "<text x=\"" +
         pixel(kLeft) + "\" y=\"16\">" + experiment.world + ", seed " +
         std::to_string(experiment.seed) +
         "</text><text class=\"ours-name\" x=\"560\" y=\"16\">ours</text>"
         "<text class=\"baseline-name\" x=\"610\" y=\"16\">baseline</text>\n" +
         body + "</svg>\n";
}

}  // namespace cloister
