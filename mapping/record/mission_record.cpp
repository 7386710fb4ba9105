#include "mapping/record/mission_record.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {

TimingSummary summarise(std::vector<float> durations_ms) {
  std::erase_if(durations_ms, [](float d) { return !std::isfinite(d); });
  if (durations_ms.empty()) return {};
  std::sort(durations_ms.begin(), durations_ms.end());
  const auto quantile = [&](double q) {
    const double rank = q * static_cast<double>(durations_ms.size() - 1);
    const auto below = static_cast<std::size_t>(rank);
    const std::size_t above = std::min(below + 1, durations_ms.size() - 1);
    const double fraction = rank - static_cast<double>(below);
    return (1.0 - fraction) * durations_ms[below] + fraction * durations_ms[above];
  };
  return {quantile(0.5), quantile(0.95), quantile(0.99), quantile(0.999),
          durations_ms.back()};
}

}  // namespace cloister
