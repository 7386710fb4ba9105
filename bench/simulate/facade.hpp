#pragma once

#include <array>
#include <vector>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/random_stream.hpp"

namespace cloister {

/// A building seen from outside only: solid, rectangular, windows set back into its walls.
struct Block {
  double min_x = 0.0;
  double min_y = 0.0;
  double max_x = 0.0;
  double max_y = 0.0;
  double height_m = 10.0;
  double bay_m = 3.2;  ///< between the middles of neighbouring windows
  std::array<bool, 4> has_windows = {true, true, true, true};  ///< south, east, north, west
};

/// Appends the block, its walls reaching 2 m into the ground. Some windows are walled up, some at
/// the ground are doors.
void append_block(const Block& block, RandomStream* random, std::vector<BoxSolid>* solids);

}  // namespace cloister
