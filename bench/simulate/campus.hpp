#pragma once

#include <cstdint>

#include "bench/simulate/world.hpp"

namespace cloister {

/// A campus of 135 x 122 m on ground that rises and falls by half a metre: a quad behind a tunnel,
/// a park with some fifty trees, streets, and buildings of up to 15 m with windows set back into
/// their walls. The path of 2.2 km takes 44 minutes at a walk: six times round the quad, through
/// the tunnel ten times, and round and across the park between.
///
///     y=122 +--------------------------------------------+
///           |  houses                                    |
///     y=105 +--------------------------------------------+
///           |  north street                              |
///      y=92 +------------------+--------+--------  ------+
///           | ################ |        |                |
///           | ## +--------+ ## |  east  |                |
///           | ## |  quad  | tunnel               park    |
///           | ## +--------+ ## | street |                |
///           | ################ |        |                |
///      y=30 +------------------+--------+-----  ---------+
///           |  south street                              |
///      y=16 +--------------------------------------------+
///           |  houses                                    |
///       y=0 +--------------------------------------------+
///          x=0   9       49    58      70               135
///
/// The seed changes the ground, the houses, trees, lamps and benches, and the path.
[[nodiscard]] World make_campus(std::uint64_t seed);

}  // namespace cloister
