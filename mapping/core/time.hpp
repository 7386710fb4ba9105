#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace cloister {

/// A stamp of the sensor's clock (whatever epoch the sensor uses: Unix time or time since its start).
/// A type of its own, so that it cannot be mixed up with the host's clock or with a duration.
struct SensorTime {
  std::int64_t ns = 0;

  friend constexpr auto operator<=>(SensorTime, SensorTime) = default;
};

/// A span of time in nanoseconds.
struct Duration {
  std::int64_t ns = 0;

  friend constexpr auto operator<=>(Duration, Duration) = default;
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
  [[nodiscard]] static Duration from_seconds(double seconds) {
    return {static_cast<std::int64_t>(std::llround(seconds * 1e9))};
  }
};

constexpr Duration operator-(SensorTime a, SensorTime b) { return {a.ns - b.ns}; }
constexpr SensorTime operator+(SensorTime a, Duration d) { return {a.ns + d.ns}; }
constexpr SensorTime operator-(SensorTime a, Duration d) { return {a.ns - d.ns}; }

}  // namespace cloister
