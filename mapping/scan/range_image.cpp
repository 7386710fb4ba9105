#include "mapping/scan/range_image.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/scan/range_image.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 8>;
using Pixels = hn::Vec<Lanes>;

// Columns whose bounds are found at once: every image's columns are a multiple of it, and its cells of up to 8 columns
// fill a vector.
constexpr int kStretch = 64;
constexpr float kMaxUnits = 65'000;
// More than a product may be rounded up by: the least of a cell is never more than any of its pixels.
constexpr float kRoundingUnits = 0.02f;

/// The one nearest to zero of values between two bounds, 0 unless all have one sign.
HWY_INLINE Pixels agreed(Pixels least, Pixels most) {
  const auto zero = hn::Zero(Lanes());
  return hn::Max(least, zero) + hn::Min(most, zero);
}

/// Replaces lost pixels between two others. Writes one more than there are columns, the first once more.
void fill_row(const float* free, int columns, float* filled) {
  const Lanes d;
  for (int column = 1; column <= columns; column += static_cast<int>(hn::Lanes(d))) {
    const auto here = hn::LoadU(d, free + column);
    const auto left = hn::LoadU(d, free + column - 1), right = hn::LoadU(d, free + column + 1);
    const auto between = agreed(hn::Min(left, right), hn::Max(left, right));
    hn::StoreU(hn::IfThenElse(here == hn::Zero(d), between, here), d, filled + column);
  }
  filled[0] = filled[columns];
}

/// What a row's cells are made from, by column.
struct Stretch {
  HWY_ALIGN float least[kStretch], most[kStretch], most_gap[kStretch];
};

/// Turns pixels into gaps, where they lie. @param lower  the row below, null under the last one
HWY_INLINE void close_gaps(const float* lower, float* filled, Stretch& stretch) {
  const Lanes d;
  for (int i = 0; i < kStretch; i += static_cast<int>(hn::Lanes(d))) {
    const auto pixel = hn::LoadU(d, filled + i);
    auto gap = hn::Zero(d);
    if (lower != nullptr) {
      const auto right = hn::LoadU(d, filled + i + 1);
      const auto below = hn::LoadU(d, lower + i), beside = hn::LoadU(d, lower + i + 1);
      gap = agreed(hn::Min(hn::Min(pixel, right), hn::Min(below, beside)),
                   hn::Max(hn::Max(pixel, right), hn::Max(below, beside)));
    }
    hn::StoreU(gap, d, filled + i);
    hn::Store(hn::Abs(pixel), d, stretch.least + i);
    hn::Store(hn::Abs(pixel), d, stretch.most + i);
    hn::Store(hn::Abs(gap), d, stretch.most_gap + i);
  }
}

/// From columns to cells of 2^squaring columns each.
HWY_INLINE void write_cells(Stretch& stretch, int squaring, float max_free_m, float units,
                            RangeImage::Bounds* cells) {
  const Lanes d;
  const auto step = static_cast<int>(hn::Lanes(d));
  int count = kStretch;
  for (int i = 0; i < squaring; ++i) {
    count /= 2;
    for (int cell = 0; cell < count; cell += step) {
      Pixels even, odd;
      hn::LoadInterleaved2(d, stretch.least + 2 * cell, even, odd);
      hn::Store(hn::Min(even, odd), d, stretch.least + cell);
      hn::LoadInterleaved2(d, stretch.most + 2 * cell, even, odd);
      hn::Store(hn::Max(even, odd), d, stretch.most + cell);
      hn::LoadInterleaved2(d, stretch.most_gap + 2 * cell, even, odd);
      hn::Store(hn::Max(even, odd), d, stretch.most_gap + cell);
    }
  }
  const hn::RebindToSigned<Lanes> di;
  const hn::Rebind<std::uint16_t, Lanes> du;
  const auto quantised = [&](Pixels value)
                             HWY_ATTR { return hn::DemoteTo(du, hn::ConvertTo(di, value)); };
  const auto scale = hn::Set(d, units);
  const auto rounded_up = [&](const float* metres) HWY_ATTR {
    return quantised(
        hn::Min(hn::Load(d, metres) * scale + hn::Set(d, 1.0f), hn::Set(d, kMaxUnits + 1)));
  };
  for (int cell = 0; cell < count; cell += step) {
    const auto least = quantised(
        hn::Max(hn::Min(hn::Load(d, stretch.least + cell), hn::Set(d, max_free_m)) * scale -
                    hn::Set(d, kRoundingUnits),
                hn::Zero(d)));
    hn::StoreInterleaved4(least, rounded_up(stretch.most + cell),
                          rounded_up(stretch.most_gap + cell), hn::Zero(du), du,
                          &cells[cell].least);
  }
}

void bound_pixels_vectors(float max_free_m, RangeImage& image) {
  const SphericalProjection& projection = *image.projection;
  const int rows = projection.num_rows(), columns = projection.num_columns;
  const int squaring = projection.squaring;
  const std::ptrdiff_t stride = image.stride;
  image.unit_m = max_free_m / kMaxUnits;
  RangeImage::Bounds* cells = image.pyramid.data();
  Stretch stretch;
  // Gaps are made where the filled pixels lie: the row below is filled just before.
  float* filled = image.gap_free_m.data();
  const float* free = image.free_m.data();
  fill_row(free, columns, filled);
  for (int row = 0; row < rows; ++row, filled += stride, free += stride) {
    const bool is_last = row + 1 == rows;
    if (!is_last) fill_row(free + stride, columns, filled + stride);
    for (int column = 0; column < columns; column += kStretch) {
      close_gaps(is_last ? nullptr : filled + stride + column, filled + column, stretch);
      write_cells(stretch, squaring, max_free_m, 1 / image.unit_m, cells);
      cells += kStretch >> squaring;
    }
    std::copy_n(filled, RangeImage::kPadding, filled + columns);
  }
}

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cloister {

HWY_EXPORT(bound_pixels_vectors);

void RangeImage::reserve(std::size_t max_pixels) {
  // Padding is at most a quarter of a row: no projection has fewer than 64 columns.
  free_m.reserve(max_pixels + max_pixels / 4);
  gap_free_m.reserve(max_pixels + max_pixels / 4);
  pyramid.reserve(2 * max_pixels);
  poses.reserve(max_pixels);
}

void RangeImage::build_bounds(float max_free_m) {
  int cell_rows = projection->num_rows();
  int cell_columns = projection->num_columns >> projection->squaring;
  gap_free_m.resize(static_cast<std::size_t>(cell_rows) * stride);
  pyramid.resize(static_cast<std::size_t>(cell_rows) * cell_columns);
  level_begin[0] = 0;
  HWY_DYNAMIC_DISPATCH(bound_pixels_vectors)(max_free_m, *this);
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
#endif
