#include "bench/simulate/stairs.hpp"

namespace cloister {

void append_flight(const Flight& flight, float albedo, std::vector<BoxSolid>* solids) {
  const double rise = flight.height_m / flight.steps;
  for (int step = 0; step < flight.steps; ++step) {
    const double y = flight.south_y + step * flight.tread_m;
    solids->push_back(BoxSolid::from_corners_m(
        {flight.min_x, y, flight.floor_m},
        {flight.max_x, y + flight.tread_m, flight.floor_m + (step + 1) * rise}, albedo));
  }
}

void append_balustrade(const BoxSolid& hole, HoleWall wall, double floor_m, float albedo,
                       std::vector<BoxSolid>* solids) {
  constexpr double kThickness = 0.05;
  constexpr double kHeight = 0.9;
  const Eigen::Vector3d min = hole.min_m();
  const Eigen::Vector3d max = hole.max_m();
  const double side = wall == HoleWall::kEast ? min.x() - kThickness : max.x();
  solids->push_back(BoxSolid::from_corners_m({side, min.y() - kThickness, floor_m},
                                             {side + kThickness, max.y(), floor_m + kHeight},
                                             albedo));
  solids->push_back(BoxSolid::from_corners_m({min.x(), min.y() - kThickness, floor_m},
                                             {max.x(), min.y(), floor_m + kHeight}, albedo));
}

}  // namespace cloister
