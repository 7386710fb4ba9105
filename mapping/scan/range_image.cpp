#include "mapping/scan/range_image.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {
namespace {

constexpr float kMaxUnits = 65'000;

/// The one nearest to zero of values between two bounds, 0 unless all have one sign.
float agreed(float least, float most) { return std::max(least, 0.0f) + std::min(most, 0.0f); }

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
  const std::size_t num_pixels = static_cast<std::size_t>(rows) * stride;
  // Written to the gaps' own memory first, row by row: a row is read by its own gaps and by those above it only.
  gap_free_m.resize(num_pixels);
  for (int row = 0; row < rows; ++row) {
    const float* free = &free_m[static_cast<std::size_t>(row) * stride];
    float* filled = &gap_free_m[static_cast<std::size_t>(row) * stride];
    const auto fill = [&](int column, int left) {
      const float between =
          agreed(std::min(free[left], free[column + 1]), std::max(free[left], free[column + 1]));
      filled[column] = free[column] != 0 ? free[column] : between;
    };
    fill(0, columns - 1);
    for (int column = 1; column < columns; ++column) fill(column, column - 1);
    filled[columns] = filled[0];
  }

  unit_m = max_free_m / kMaxUnits;
  const float units = 1 / unit_m;
  const int squaring = projection->squaring;
  int cell_columns = columns >> squaring;
  int cell_rows = rows;
  pyramid.resize(static_cast<std::size_t>(cell_rows) * cell_columns);
  level_begin[0] = 0;
  const auto rounded_up = [&](float m) {
    return static_cast<std::uint16_t>(std::min(m * units + 1, kMaxUnits + 1));
  };
  for (int row = 0; row < rows; ++row) {
    float* filled = &gap_free_m[static_cast<std::size_t>(row) * stride];
    Bounds* cells = &pyramid[static_cast<std::size_t>(row) * cell_columns];
    for (int cell = 0; cell < cell_columns; ++cell) {
      float least = max_free_m, most = 0;
      for (int column = cell << squaring; column < (cell + 1) << squaring; ++column) {
        least = std::min(least, std::abs(filled[column]));
        most = std::max(most, std::abs(filled[column]));
      }
      cells[cell] = {static_cast<std::uint16_t>(least * units), rounded_up(most), 0};
    }
    const float* lower = row + 1 < rows ? filled + stride : filled;
    for (int column = 0; column < columns; ++column) {
      const float a = filled[column], b = filled[column + 1], c = lower[column],
                  d = lower[column + 1];
      filled[column] = agreed(std::min(std::min(a, b), std::min(c, d)),
                              std::max(std::max(a, b), std::max(c, d)));
    }
    if (row + 1 == rows) std::fill_n(filled, columns, 0.0f);
    for (int cell = 0; cell < cell_columns; ++cell) {
      float most_gap = 0;
      for (int column = cell << squaring; column < (cell + 1) << squaring; ++column) {
        most_gap = std::max(most_gap, std::abs(filled[column]));
      }
      cells[cell].most_gap = rounded_up(most_gap);
    }
    std::copy_n(filled, kPadding, filled + columns);
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
      Bounds* cells =
          &pyramid[level_begin[num_levels] + static_cast<std::size_t>(row) * cell_columns];
      for (int cell = 0; cell < cell_columns; ++cell) {
        const Bounds &a = upper[2 * cell], &b = upper[2 * cell + 1], &c = lower[2 * cell],
                     &d = lower[2 * cell + 1];
        cells[cell] = {
            std::min(std::min(a.least, b.least), std::min(c.least, d.least)),
            std::max(std::max(a.most, b.most), std::max(c.most, d.most)),
            std::max(std::max(a.most_gap, b.most_gap), std::max(c.most_gap, d.most_gap))};
      }
    }
  }
}

}  // namespace cloister
