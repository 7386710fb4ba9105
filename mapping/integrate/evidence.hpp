#pragma once

#include "mapping/core/config.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What one observation is worth, and how sure a voxel can become; in steps of log-odds.
struct Evidence {
  explicit Evidence(const VoxelConfig& config)
      : hit(log_odds_steps(config.log_odds_hit)),
        miss(log_odds_steps(config.log_odds_miss)),
        lowest(log_odds_steps(config.log_odds_min)),
        highest(log_odds_steps(config.log_odds_max)) {}

  LogOdds hit;
  LogOdds miss;
  LogOdds lowest;
  LogOdds highest;
};

/// Sum of two observations within limits; what cancels exactly keeps the sign of `evidence`.
[[nodiscard]] constexpr LogOdds add_log_odds(int value, int evidence, int lowest, int highest) {
  const int sum = value + evidence;
  const int kept = sum < lowest ? lowest : sum > highest ? highest : sum;
  return static_cast<LogOdds>(kept != 0 ? kept : evidence < 0 ? -1 : evidence > 0 ? 1 : 0);
}

}  // namespace cloister
