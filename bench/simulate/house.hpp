#pragma once

#include <cstdint>

#include "bench/simulate/world.hpp"

namespace cloister {

/// A house of two storeys, 12.2 x 10 m: a hall and four rooms below, a landing and four rooms
/// above, joined by one flight of stairs. The path leads through every room twice and ends where it
/// began.
///
///     y=10 +--------+------+--------+        +--------+------+--------+
///          | living | hall |workshop|        | bed A  |landing| office|
///      y=5 +--  ----+  ##  +----  --+        +--  ----+  ##  |        |
///          | kitchen|  ##  | study  |        | bed B  |      +--  ----+ y=4
///      y=0 +--------+------+--------+        +--------+------+--bath--+
///          x=0     4.6    7.6    12.2         ## stairs, rising with y
///
/// The seed moves the doors a little, chooses and places the furniture, and shifts the path inside
/// the rooms.
[[nodiscard]] World make_house(std::uint64_t seed);

}  // namespace cloister
