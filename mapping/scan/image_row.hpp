#pragma once

#include <cstddef>

#include "mapping/scan/spherical_projection.hpp"

namespace cloister {

/// One row of a scan on its way into a RangeImage. Pointers are to rows of a destaggered image, padded for vector loads.
struct ImageRow {
  const SphericalProjection* projection = nullptr;
  int row = 0;
  int num_columns = 0;
  const float* range_m =
      nullptr;  ///< element -1 repeats the last column, num_columns the first; 0 = no return
  const float* above_m = nullptr;  ///< the rows above and below; null where there is none
  const float* below_m = nullptr;
  float angle_above_rad = 0;  ///< between the rows
  float angle_below_rad = 0;
  const float* column_pose = nullptr;  ///< [12 x pose_stride] R_S_L row by row, then t_S
  std::size_t pose_stride = 0;
  float voxel_m = 0;
  float max_free_m = 0;     ///< no beam proves more
  float max_return_m = 0;   ///< returns beyond are no surfaces
  float* free_m = nullptr;  ///< out: how far each beam proves space free
  float *x_S = nullptr, *y_S = nullptr, *z_S = nullptr;  ///< out: returns, without gaps
};

/// Computes `free_m` and the returns of one row (beam model: see ScanBeams). @return number of returns
/// Vectorised for whatever the processor has; every instruction set gives the same bits.
[[nodiscard]] std::size_t place_row(const ImageRow& row);

}  // namespace cloister
