#pragma once

#include <ostream>
#include <span>

#include <Eigen/Core>

#include "firmware_interface/map/map_query.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// Answers each point (M, metres) with a line `x,y,z,state,log_odds,submap` under a header of these
/// names. Log-odds are natural; an unknown point has log-odds 0 and submap -1. Fails with kResource
/// when the stream stops taking lines.
[[nodiscard]] Result<void> write_states_csv(const MapQuery& query,
                                            std::span<const Eigen::Vector3d> points_M,
                                            std::ostream& out);

}  // namespace cloister
