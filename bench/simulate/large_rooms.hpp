#pragma once

#include <cstdint>

#include "bench/simulate/world.hpp"

namespace cloister {

/// A storey of 60.4 x 34.4 m: three halls of 12 x 18 m and 42 rooms around four corridors. The path
/// of about 700 m begins in the middle hall, leaves it ten times and comes back to it: through the
/// rooms of one half of the south or north row, through four rooms beside the hall, or through one
/// of the other halls.
///
///     y=34.4 +--+--+--+--+--+--+--+--+--+--+--+--+--+
///            |13 rooms of 4.6 x 6 m                 |
///     y=28.4 +--+--+--+--+--+--+--+--+--+--+--+--+--+
///            |           north corridor             |
///     y=26.2 +-------+-+----+--------+----+-+-------+
///            |       | |    |        |    | |       |
///            | hall  | | 8  |  hall  | 8  | | hall  |
///            |       | |    |        |    | |       |
///     y=8.2  +-------+-+----+--------+----+-+-------+
///            |           south corridor             |
///     y=6    +--+--+--+--+--+--+--+--+--+--+--+--+--+
///            |13 rooms of 4.6 x 6 m                 |
///     y=0    +--+--+--+--+--+--+--+--+--+--+--+--+--+
///            x=0    12 14.2 24.2    36.2 46.2 48.4  60.4
///
/// The seed changes doors, furniture, windows, and the path: in which order and which way round its
/// ten parts are walked.
[[nodiscard]] World make_large_rooms(std::uint64_t seed);

}  // namespace cloister
