#pragma once

#include <cstdint>

#include "bench/simulate/world.hpp"

namespace cloister {

/// Nine furnished rooms of 4 to 5 m, three by three, joined by doorways 0.9 m wide. The path makes
/// six rounds through all of them, the first three in one direction, the others in the other:
/// round the outside from A to H, into the middle, and by B back to A.
///
///     +---+---+---+
///     | G | F | E |
///     +- -+- -+- -+
///     | H   M   D |    and doorways between all neighbours of the outer ring; those
///     +- -+- -+- -+    of the middle room with D and F are there for some seeds only
///     | A | B | C |
///     +---+---+---+
///
/// The seed changes the rooms' sizes, doors, furniture and path.
[[nodiscard]] World make_small_rooms(std::uint64_t seed);

}  // namespace cloister
