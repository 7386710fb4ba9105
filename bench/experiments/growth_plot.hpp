#pragma once

#include <string>

#include "bench/experiments/experiment.hpp"

namespace cloister {

/// Memory of the map above, number of submaps below, against the mission's time, ours and the baseline; where rounds
/// end, an upright line. A whole SVG document; long timelines are drawn by the least and the most of each of some
/// hundred intervals.
[[nodiscard]] std::string growth_plot_svg(const Experiment& experiment);

}  // namespace cloister
