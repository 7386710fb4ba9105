#pragma once

#include <vector>

#include "bench/simulate/box_solid.hpp"

namespace cloister {

/// A hole in a wall: a doorway when it begins at the floor, else a window.
struct Opening {
  double center_m = 0.0;  ///< along the wall, in the coordinate the wall runs along
  double width_m = 0.9;
  double bottom_m = 0.0;  ///< above the wall's foot
  double top_m = 2.0;     ///< above the wall's foot
};

/// A straight wall on one grid line of a floor plan.
struct Wall {
  bool along_x = false;  ///< runs along x at y = line_m, else along y at x = line_m
  double line_m = 0.0;   ///< of its middle plane
  double from_m = 0.0;
  double to_m = 0.0;
  double foot_m = 0.0;  ///< z of its lower edge
  double height_m = 2.6;
  double thickness_m = 0.14;
  std::vector<Opening> openings;  ///< in any order, not overlapping
};

/// Cuts a wall into blocks around its openings and appends them.
void append_wall(const Wall& wall, float albedo, std::vector<BoxSolid>* solids);

/// A horizontal slab with one rectangular hole, as up to four blocks.
void append_slab_with_hole(const BoxSolid& slab, const BoxSolid& hole,
                           std::vector<BoxSolid>* solids);

}  // namespace cloister
