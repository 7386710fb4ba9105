#include "mapping/record/mission_record.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

// The value below which a share q of the area under the piecewise linear quantile curve lies, found
// by walking it.
double percentile_by_walking(std::vector<float> sorted, double q) {
  std::sort(sorted.begin(), sorted.end());
  const double step = 1.0 / static_cast<double>(sorted.size() - 1);
  for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
    const double from = static_cast<double>(i) * step;
    if (q <= from + step) return sorted[i] + (sorted[i + 1] - sorted[i]) * (q - from) / step;
  }
  return sorted.back();
}

TEST_CASE("no durations summarise to zeros") {
  const TimingSummary summary = summarise({});
  CHECK(summary.p50 == 0);
  CHECK(summary.max == 0);
}

TEST_CASE("a single duration is every percentile of itself") {
  const TimingSummary summary = summarise({7.5f});
  CHECK(summary.p50 == 7.5);
  CHECK(summary.p95 == 7.5);
  CHECK(summary.p99 == 7.5);
  CHECK(summary.max == 7.5);
}

TEST_CASE("percentiles of shuffled durations agree with walking the sorted ones") {
  const unsigned seed = 11;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::lognormal_distribution<float> duration(3.0f, 0.6f);
  for (const std::size_t size : {2u, 3u, 14u, 100u, 1001u}) {
    CAPTURE(size);
    std::vector<float> durations(size);
    for (float& d : durations) d = duration(random);
    const TimingSummary summary = summarise(durations);
    CHECK(summary.p50 == doctest::Approx(percentile_by_walking(durations, 0.50)).epsilon(1e-6));
    CHECK(summary.p95 == doctest::Approx(percentile_by_walking(durations, 0.95)).epsilon(1e-6));
    CHECK(summary.p99 == doctest::Approx(percentile_by_walking(durations, 0.99)).epsilon(1e-6));
    CHECK(summary.max == *std::max_element(durations.begin(), durations.end()));
  }
}

TEST_CASE("durations that are not finite are left out") {
  const TimingSummary summary = summarise({1.0f, std::numeric_limits<float>::quiet_NaN(), 3.0f,
                                           std::numeric_limits<float>::infinity()});
  CHECK(summary.p50 == 2.0);
  CHECK(summary.max == 3.0);
}

}  // namespace
}  // namespace cloister
