#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "mapping/scan/spherical_projection.hpp"

namespace cloister {

/// How far each beam of an organised scan proves space free, as a destaggered image in the sensor's own beam table,
/// with what a coarse-to-fine search needs. Distances are from the projection's ring, metres; 0 = nothing is proven.
///
/// Filled by ScanBeams. All memory is taken by `reserve`.
struct RangeImage {
  /// The sensor's pose while a column was measured: p_L = R_L_S (p_S - t_S).
  struct ColumnPose {
    float R_L_S[3][3];
    Eigen::Vector3f t_S;
  };
  /// Of a cell's free distances, in units of `unit_m`, each rounded to the safe side.
  struct alignas(8) Bounds {
    std::uint16_t least;  ///< a lost pixel between two others counts as the lesser of both
    std::uint16_t most;
    std::uint16_t most_gap;  ///< the most of `gap_free_m`
    std::uint16_t padding = 0;
  };

  /// Elements of padding behind each row: vector loads may run past a row's end. The first repeats column 0.
  static constexpr int kPadding = 16;
  static constexpr int kMaxLevels = 12;

  const SphericalProjection* projection = nullptr;  ///< null while there is no image
  int stride = 0;                                   ///< num_columns + kPadding
  /// [num_rows x stride] Negative where the beam was fired a whole turn before or after its neighbours in the image,
  /// while the sensor was moving: such a pixel answers only who asks with that end's pose.
  std::vector<float> free_m;
  /// [num_rows x stride] Least of a pixel, the one right of it and the two below them: what all four beams around a
  /// direction prove; negative if all four are. A lost pixel between two others proves what the lesser of them does.
  std::vector<float> gap_free_m;
  /// Level k bounds cells of 2^k rows and 2^(k + squaring) columns; rows of cells from the top.
  std::vector<Bounds> pyramid;
  std::uint32_t level_begin[kMaxLevels] = {};
  int num_levels = 0;
  float unit_m = 0.001f;

  std::vector<ColumnPose> poses;  ///< [num_columns]
  float turned_rad = 0;           ///< by how much the sensor turned and moved during the scan
  float moved_m = 0;

  void reserve(std::size_t max_pixels);
  /// Fills `gap_free_m` and `pyramid` from `free_m`. @param max_free_m  no free distance is longer
  void build_bounds(float max_free_m);
};

}  // namespace cloister
