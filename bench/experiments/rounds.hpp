#pragma once

#include <vector>

#include "bench/ground_truth/truth.hpp"

namespace cloister {

/// When the way has come round: each time it is back in the first room after it has seen all the others, at the moment
/// it is nearest to that room's middle. Empty for a world without rooms or a way that does not come round.
[[nodiscard]] std::vector<SensorTime> round_ends(const GroundTruth& truth);

/// Final submaps that hold scans of two storeys or more. Scans count when they were taken at least `margin_m` inside
/// a room; rooms named "... stairwell" do not count, since stairs belong to both storeys.
[[nodiscard]] std::size_t submaps_across_storeys(const GroundTruth& truth,
                                                 const std::vector<SubmapScans>& submaps,
                                                 double margin_m = 0.6);

}  // namespace cloister
