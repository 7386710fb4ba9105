#pragma once

#include "bench/simulate/trajectory.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// How often a walk enters a room. Who is inside has to come out again: standing in the door is one visit.
inline int visits(const Room& room, const Trajectory& truth) {
  int count = 0;
  bool was_inside = false;
  for (const Pose& pose : truth.poses) {
    const bool is_inside = room.contains(pose.translation(), was_inside ? 0.0 : 0.3);
    count += is_inside && !was_inside ? 1 : 0;
    was_inside = is_inside;
  }
  return count;
}

}  // namespace cloister
