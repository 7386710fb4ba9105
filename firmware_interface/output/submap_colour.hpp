#pragma once

#include <cstdint>
#include <string>

#include "mapping/submap/submap.hpp"

namespace cloister {

/// An sRGB colour, 8 bits a channel.
struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;

  friend bool operator==(const Rgb&, const Rgb&) = default;
};

/// The colour of a submap in meshes, plans and tables. Fixed per id, so that pictures of two runs
/// can be compared; ids that follow each other are far apart, and every colour stands out from
/// white and from black.
[[nodiscard]] Rgb submap_colour(SubmapId id);

/// "#rrggbb".
[[nodiscard]] std::string hex_colour(Rgb colour);

}  // namespace cloister
