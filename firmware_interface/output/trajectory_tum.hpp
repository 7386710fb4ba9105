#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// The text of trajectory.tum: a comment, then a line `t x y z qx qy qz qw` for each pose; t in
/// seconds with exactly nine decimals, metres and unit quaternions in the shortest form that reads
/// back to the same double.
[[nodiscard]] std::string trajectory_tum(const std::vector<std::pair<SensorTime, Pose>>& path_M);

}  // namespace cloister
