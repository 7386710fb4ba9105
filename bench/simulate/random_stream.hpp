#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace cloister {

/// A small generator (splitmix64) that is cheap to start: one stream per thing that needs noise,
/// named by numbers.
///
/// Noise drawn from a stream of its own does not depend on what other streams draw, so results are
/// the same for any number of threads. The standard's distributions differ between libraries; these
/// do not.
class RandomStream {
 public:
  /// @param seed the mission's seed; `purpose` and `index` name the stream within it
  RandomStream(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index = 0)
      : state_(mix(mix(mix(seed + kStep) ^ (purpose * kStep)) ^ (index * 0xd1b54a32d192ed03ULL))) {}

  std::uint64_t bits() {
    state_ += kStep;
    return mix(state_);
  }

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform in 0 .. count - 1.
  std::uint64_t below(std::uint64_t count) {
    return static_cast<std::uint64_t>(uniform() * static_cast<double>(count));
  }

  /// Normal with mean 0 and standard deviation 1 (Box-Muller, its second value is kept for the next
  /// call).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;

  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// Names of the streams, so that no two purposes share one.
enum class Purpose : std::uint64_t {
  kWorld = 1,
  kPath,
  kShake,
  kReturns,
  kOdometry,
  kLoopClosures,
  kBeams,
  kSampling,
  kWrongClosures
};

[[nodiscard]] inline RandomStream random_stream(std::uint64_t seed, Purpose purpose,
                                                std::uint64_t index = 0) {
  return {seed, static_cast<std::uint64_t>(purpose), index};
}

}  // namespace cloister
