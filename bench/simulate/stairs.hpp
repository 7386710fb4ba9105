#pragma once

#include <vector>

#include "bench/simulate/box_solid.hpp"

namespace cloister {

/// A straight flight of solid steps that rises with y.
struct Flight {
  double min_x = 0.0;
  double max_x = 0.0;
  double south_y = 0.0;  ///< where the first step begins
  double floor_m = 0.0;  ///< z of its foot
  double height_m = 2.85;
  int steps = 15;
  double tread_m = 0.28;

  [[nodiscard]] constexpr double north_y() const { return south_y + steps * tread_m; }
  [[nodiscard]] constexpr double top_m() const { return floor_m + height_m; }
};

void append_flight(const Flight& flight, float albedo, std::vector<BoxSolid>* solids);

/// Which long side of a stairwell's hole is a wall.
enum class HoleWall { kEast, kWest };

/// A balustrade around a hole, 0.9 m high: along its southern edge and along the side that is no
/// wall; to the north the stairs arrive.
/// @param hole its x and y count @param floor_m z of the floor around it
void append_balustrade(const BoxSolid& hole, HoleWall wall, double floor_m, float albedo,
                       std::vector<BoxSolid>* solids);

}  // namespace cloister
