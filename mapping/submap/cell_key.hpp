#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace cloister {

/// Integer coordinates of a cell as one number, 21 bits an axis: cells within a million of the origin differ.
[[nodiscard]] constexpr std::uint64_t cell_key(std::int32_t x, std::int32_t y, std::int32_t z) {
  constexpr std::int32_t kOffset = 1 << 20;
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(x + kOffset) & kMask) | ((static_cast<std::uint64_t>(y + kOffset) & kMask) << 21) |
         ((static_cast<std::uint64_t>(z + kOffset) & kMask) << 42);
}

/// Where the search for a key begins in a table of a power of two places.
[[nodiscard]] constexpr std::size_t first_place(std::uint64_t key, std::size_t table_size) {
  return (key * 0x9e3779b97f4a7c15ull >> 20) & (table_size - 1);
}

/// Coordinates of the cell that holds a point.
[[nodiscard]] inline Eigen::Vector3i cell_of(const Eigen::Vector3f& point, float cells_per_metre) {
  return {static_cast<std::int32_t>(std::floor(point.x() * cells_per_metre)),
          static_cast<std::int32_t>(std::floor(point.y() * cells_per_metre)),
          static_cast<std::int32_t>(std::floor(point.z() * cells_per_metre))};
}

}  // namespace cloister
