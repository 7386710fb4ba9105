#pragma once

#include <vector>

#include "bench/simulate/height_field.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// The way through the campus, 1.2 m above its ground.
[[nodiscard]] std::vector<Waypoint> walk_campus(const HeightField& ground, RandomStream* random);

}  // namespace cloister
