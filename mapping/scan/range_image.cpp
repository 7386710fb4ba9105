#include "mapping/scan/range_image.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {
namespace {

constexpr float kMaxUnits = 65'000;

}  // namespace

void RangeImage::reserve(std::size_t max_pixels) {
  // Padding is at most a quarter of a row: no projection has fewer than 64 columns.
  free_m.reserve(max_pixels + max_pixels / 4);
  gap_free_m.reserve(max_pixels + max_pixels / 4);
  pyramid.reserve(2 * max_pixels);
  poses.reserve(max_pixels);
}

void RangeImage::build_bounds(float max_free_m) {
  const int rows = projection->num_rows();
  const int columns = projection->num_columns;
  gap_free_m.resize(static_cast<std::size_t>(std::max(rows - 1, 1)) * stride);
  for (int row = 0; row + 1 < rows; ++row) {
    const float* upper = &free_m[static_cast<std::size_t>(row) * stride];
    const float* lower = upper + stride;
    float* gap = &gap_free_m[static_cast<std::size_t>(row) * stride];
    for (int column = 0; column < columns; ++column) {
      const float least = std::min(std::min(upper[column], upper[column + 1]), std::min(lower[column], lower[column + 1]));
      gap[column] = std::max(least, 0.0f);
    }
  }

  unit_m = max_free_m / kMaxUnits;
  const float units = 1 / unit_m;
  const int squaring = projection->squaring;
  int cell_columns = columns >> squaring;
  int cell_rows = rows;
  pyramid.resize(static_cast<std::size_t>(cell_rows) * cell_columns);
  level_begin[0] = 0;
  for (int row = 0; row < rows; ++row) {
    const float* free = &free_m[static_cast<std::size_t>(row) * stride];
    for (int cell = 0; cell < cell_columns; ++cell) {
      float least = max_free_m, most = 0;
      for (int column = cell << squaring; column < (cell + 1) << squaring; ++column) {
        least = std::min(least, free[column]);
        most = std::max(most, std::abs(free[column]));
      }
      pyramid[static_cast<std::size_t>(row) * cell_columns + cell] = {
          static_cast<std::uint16_t>(std::max(least, 0.0f) * units),
          static_cast<std::uint16_t>(std::min(most * units + 1, kMaxUnits + 1))};
    }
  }
  for (num_levels = 1; num_levels < kMaxLevels && cell_columns > 2; ++num_levels) {
    const std::size_t below = level_begin[num_levels - 1];
    const int below_rows = cell_rows, below_columns = cell_columns;
    cell_rows = (cell_rows + 1) / 2;
    cell_columns /= 2;
    level_begin[num_levels] = static_cast<std::uint32_t>(pyramid.size());
    pyramid.resize(pyramid.size() + static_cast<std::size_t>(cell_rows) * cell_columns);
    for (int row = 0; row < cell_rows; ++row) {
      const Bounds* upper = &pyramid[below + static_cast<std::size_t>(2 * row) * below_columns];
      const Bounds* lower = 2 * row + 1 < below_rows ? upper + below_columns : upper;
      Bounds* cells = &pyramid[level_begin[num_levels] + static_cast<std::size_t>(row) * cell_columns];
      for (int cell = 0; cell < cell_columns; ++cell) {
        const Bounds &a = upper[2 * cell], &b = upper[2 * cell + 1], &c = lower[2 * cell], &d = lower[2 * cell + 1];
        cells[cell] = {std::min(std::min(a.least, b.least), std::min(c.least, d.least)),
                       std::max(std::max(a.most, b.most), std::max(c.most, d.most))};
      }
    }
  }
}

}  // namespace cloister
