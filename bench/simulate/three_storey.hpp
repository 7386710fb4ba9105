#pragma once

#include <cstdint>

#include "bench/simulate/world.hpp"

namespace cloister {

/// An office building of three storeys, 20 x 13.6 m: basement, ground floor and first floor, each
/// with a corridor, joined by a stairwell of two straight flights. The path begins in the corridor
/// of the ground floor, visits every room of that floor, of the first floor and of the basement,
/// and comes back.
///
///     y=13.6 +-----+-----+--------+-----+-----+     The basement has one store in the
///            |     |     |  stair |     |     |     place of every two rooms.
///            |          -+-  well +-          |
///      y=7   +- ---+- ---+-- -----+- ---+- ---+
///            |             corridor           |
///      y=5   +- ----+- -----+- ----+- -----+
///            |      |       |      |       |
///      y=0   +------+-------+------+-------+
///           x=0     5      10     15      20
///
/// The seed changes doors, furniture, windows and path.
[[nodiscard]] World make_three_storey(std::uint64_t seed);

}  // namespace cloister
