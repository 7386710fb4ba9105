#include "mapping/scan/image_row.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/scan/image_row.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A surface seen at less than half a degree: what looks steeper is an edge.
constexpr float kMaxSlope = 115.0f;

/// Change of range per metre across the beam towards a neighbour `angle` away, from the chord between both returns.
template <class V>
HWY_INLINE V chord_slope(V range, V neighbour, V angle, V flat) {
  return (neighbour * flat - range) / (neighbour * angle);
}

/// Slope towards the nearer in range of two neighbours on either side, rising towards the first; 0 when there is none.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V nearer_slope(D d, V range, V one, V angle_one, V other, V angle_other) {
  const V zero = hn::Zero(d), unit = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f),
          far = hn::Set(d, 1e9f);
  const V gap_one = hn::IfThenElse(one > zero, hn::Abs(one - range), far);
  const V gap_other = hn::IfThenElse(other > zero, hn::Abs(other - range), far);
  const auto use_one = gap_one <= gap_other;
  const V angle = hn::IfThenElse(use_one, angle_one, angle_other);
  const V slope =
      chord_slope(range, hn::IfThenElse(use_one, one, other), angle, unit - half * angle * angle);
  const V rising = hn::IfThenElse(use_one, slope, hn::Neg(slope));
  // Also false for the quotients by zero of pixels without neighbours.
  const auto is_surface =
      hn::And(hn::Min(gap_one, gap_other) < far, hn::Abs(slope) < hn::Set(d, kMaxSlope));
  return hn::IfThenElseZero(is_surface, rising);
}

/// Ranges of a row above or below; for a pixel that is lost, the one beside it that is nearer in range to `range`.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V neighbours_in(D d, const float* row_m, int column, V range) {
  const V zero = hn::Zero(d);
  if (row_m == nullptr) return zero;
  const V straight = hn::LoadU(d, row_m + column);
  const auto is_lost = straight == zero;
  if (hn::AllFalse(d, is_lost)) return straight;
  const V left = hn::LoadU(d, row_m + column - 1), right = hn::LoadU(d, row_m + column + 1);
  const auto use_left =
      hn::Or(right == zero, hn::And(left > zero, hn::Abs(left - range) <= hn::Abs(right - range)));
  return hn::IfThenElse(is_lost, hn::IfThenElse(use_left, left, right), straight);
}

std::size_t place_row_vectors(const ImageRow& in) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const SphericalProjection& projection = *in.projection;
  const SphericalProjection::Row& row = projection.rows[in.row];
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5f);
  const V sin_up = hn::Set(d, row.sin_elevation), cos_up = hn::Set(d, row.cos_elevation);
  const V sin_off = hn::Set(d, row.sin_residual), cos_off = hn::Set(d, row.cos_residual);
  const V tangential = hn::Set(d, row.tangential_m);
  const V ring_radius = hn::Set(d, projection.ring_radius_m),
          ring_height = hn::Set(d, projection.ring_height_m);
  const V beside = hn::Set(
      d, row.cos_elevation / (projection.columns_per_rad > 0 ? projection.columns_per_rad
                                                             : -projection.columns_per_rad));
  const V turn = hn::Set(d, projection.columns_per_rad > 0 ? 1.0f : -1.0f);
  const V angle_above = hn::Set(d, in.angle_above_rad),
          angle_below = hn::Set(d, in.angle_below_rad);
  const V half_voxel = hn::Set(d, 0.5f * in.voxel_m);
  const V max_free = hn::Set(d, in.max_free_m), max_return = hn::Set(d, in.max_return_m);

  std::size_t num_returns = 0;
  for (int column = 0; column < in.num_columns; column += static_cast<int>(hn::Lanes(d))) {
    const V range = hn::LoadU(d, in.range_m + column);
    const auto is_valid = range > zero;
    if (hn::AllFalse(d, is_valid)) {
      hn::StoreU(zero, d, in.free_m + column);
      continue;
    }
    const V left = hn::LoadU(d, in.range_m + column - 1),
            right = hn::LoadU(d, in.range_m + column + 1);
    const V above = neighbours_in(d, in.above_m, column, range);
    const V below = neighbours_in(d, in.below_m, column, range);
    const V slope_around = nearer_slope(d, range, right, beside, left, beside) * turn;
    const V slope_up = nearer_slope(d, range, above, angle_above, below, angle_below);

    // The beam and the directions of rising azimuth and elevation across it, in L.
    const V cos_image = hn::LoadU(d, &projection.cos_azimuth[column]);
    const V sin_image = hn::LoadU(d, &projection.sin_azimuth[column]);
    const V cos_around = cos_image * cos_off - sin_image * sin_off;
    const V sin_around = sin_image * cos_off + cos_image * sin_off;
    const V out = cos_up + slope_up * sin_up;  // N = beam - slope_around * around - slope_up * up
    const V normal_x = out * cos_around + slope_around * sin_around;
    const V normal_y = out * sin_around - slope_around * cos_around;
    const V normal_z = sin_up - slope_up * cos_up;
    const V rho = ring_radius + range * cos_up;
    const V x = rho * cos_around - tangential * sin_around;
    const V y = rho * sin_around + tangential * cos_around;
    const V z = ring_height + range * sin_up;

    const float* pose = in.column_pose + column;
    const auto entry = [&](int i) HWY_ATTR { return hn::LoadU(d, pose + i * in.pose_stride); };
    const V r00 = entry(0), r01 = entry(1), r02 = entry(2), r10 = entry(3), r11 = entry(4),
            r12 = entry(5);
    const V r20 = entry(6), r21 = entry(7), r22 = entry(8);
    const V norm = hn::Abs(r00 * normal_x + r01 * normal_y + r02 * normal_z) +
                   hn::Abs(r10 * normal_x + r11 * normal_y + r12 * normal_z) +
                   hn::Abs(r20 * normal_x + r21 * normal_y + r22 * normal_z);
    const V steepness = hn::Sqrt(normal_x * normal_x + normal_y * normal_y + normal_z * normal_z);
    const V stretch = half_voxel * (norm + steepness - hn::Set(d, 1.0f));
    const V free = hn::Min(hn::Max(range - stretch, half * hn::Min(range, max_free)), max_free);
    hn::StoreU(hn::IfThenElseZero(is_valid, free), d, in.free_m + column);

    const auto is_return = hn::And(is_valid, range <= max_return);
    // Compressed in a register: some processors take a hundred cycles to do it on the way to memory.
    hn::StoreU(hn::Compress(r00 * x + r01 * y + r02 * z + entry(9), is_return), d,
               in.x_S + num_returns);
    hn::StoreU(hn::Compress(r10 * x + r11 * y + r12 * z + entry(10), is_return), d,
               in.y_S + num_returns);
    hn::StoreU(hn::Compress(r20 * x + r21 * y + r22 * z + entry(11), is_return), d,
               in.z_S + num_returns);
    num_returns += hn::CountTrue(d, is_return);
  }
  return num_returns;
}

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cloister {

HWY_EXPORT(place_row_vectors);

std::size_t place_row(const ImageRow& row) { return HWY_DYNAMIC_DISPATCH(place_row_vectors)(row); }

}  // namespace cloister
#endif
