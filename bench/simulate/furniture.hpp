#pragma once

#include <span>
#include <vector>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

enum class Piece {
  kTable,
  kLowTable,
  kChair,
  kShelf,
  kBed,
  kSofa,
  kWardrobe,
  kCounter,
  kCabinet,
  kTub,
  kCrate
};

/// Puts pieces into a room, most of them with their back to a wall, where they neither touch each
/// other nor come closer to the path than `clearance_m` (seen from above). A piece that finds no
/// place is left out.
/// @param path_W points of the path, densely spaced; only those inside the room count
void furnish(const Room& room, std::span<const Piece> pieces,
             std::span<const Eigen::Vector3d> path_W, double clearance_m, RandomStream* random,
             std::vector<BoxSolid>* solids);

}  // namespace cloister
