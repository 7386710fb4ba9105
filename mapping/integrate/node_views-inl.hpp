// How nodes of the volume look from the sensor, compiled once for each instruction set (see block_update-inl.hpp).
#if defined(CLOISTER_NODE_VIEWS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef CLOISTER_NODE_VIEWS_INL_HPP
#undef CLOISTER_NODE_VIEWS_INL_HPP
#else
#define CLOISTER_NODE_VIEWS_INL_HPP
#endif

#include <algorithm>
#include <cmath>

#include <hwy/highway.h>

#include "mapping/scan/range_image.hpp"
#include "mapping/voxel/voxel.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float kHalfDiagonal = 0.8660254f;  // of a cube of edge 1
// What rounding may be wrong by, in columns or rows.
constexpr float kAngleSlack = 0.01f;

/// Eight nodes at once, children of one.
using Lanes8 = hn::CappedTag<float, 8>;
using Ints8 = hn::RebindToSigned<Lanes8>;

/// How eight sibling nodes look from the sensor. Gradients are per voxel along S's axes.
struct NodeViews {
  HWY_ALIGN float column[8], sine[8], distance_m[8], axis_m[8];
  HWY_ALIGN float row[8], rows_per_sine[8];
  HWY_ALIGN float column_step[3][8], sine_step[3][8], distance_step[3][8];
  unsigned free = 0;   ///< bit i: child i is free throughout
  unsigned mixed = 0;  ///< bit i: child i must be divided
  unsigned gaps = 0;   ///< bit i: some of it may be seen through by all four beams around
};

/// How the surroundings of a point look from the sensor, to first order. Steps are per voxel along S's axes.
struct LinearView {
  LinearView(const NodeViews& views, int child)
      : column(views.column[child]),
        sine(views.sine[child]),
        distance_m(views.distance_m[child]),
        row(views.row[child]),
        rows_per_sine(views.rows_per_sine[child]) {
    for (int i = 0; i < 3; ++i) {
      column_step[i] = views.column_step[i][child];
      sine_step[i] = views.sine_step[i][child];
      distance_step[i] = views.distance_step[i][child];
    }
  }

  float column, sine, distance_m;  ///< sine of the elevation
  float row, rows_per_sine;
  float column_step[3], sine_step[3], distance_step[3];
};

/// Which pose a node is projected with, and how much of the scan's motion happened while its beams were fired.
struct NodePose {
  const RangeImage::ColumnPose* pose;
  float share;
};

/// Arc tangent of y / x in all four quadrants, to 1e-5 rad (Abramowitz and Stegun, 4.4.47).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V azimuth(D d, V y, V x) {
  const V abs_x = hn::Abs(x), abs_y = hn::Abs(y);
  const V quotient = hn::Min(abs_x, abs_y) / hn::Max(hn::Max(abs_x, abs_y), hn::Set(d, 1e-20f));
  const V s = quotient * quotient;
  V angle = hn::Set(d, 0.0208351f) * s - hn::Set(d, 0.0851330f);
  angle = angle * s + hn::Set(d, 0.1801410f);
  angle = angle * s - hn::Set(d, 0.3302995f);
  angle = (angle * s + hn::Set(d, 0.9998660f)) * quotient;
  angle = hn::IfThenElse(abs_y > abs_x, hn::Set(d, 1.57079633f) - angle, angle);
  angle = hn::IfThenElse(x < hn::Zero(d), hn::Set(d, 3.14159265f) - angle, angle);
  return hn::CopySign(angle, y);
}

/// One bit a lane, sixteen at the most.
template <class D, class M>
HWY_INLINE unsigned mask_bits(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | (unsigned{bytes[1]} << 8);
}

/// Projects nodes of the volume into a range image.
class NodeProjector {
 public:
  NodeProjector(const RangeImage& range_image, float voxel_edge_m, float longest_m)
      : image(range_image),
        projection(*range_image.projection),
        voxel_m(voxel_edge_m),
        column_mask(projection.num_columns - 1),
        max_range_m_(longest_m),
        columns_per_rad_(std::abs(projection.columns_per_rad)),
        // It matters where the scan's motion is more than a fraction of a column, or of a voxel.
        has_seam_(image.turned_rad * columns_per_rad_ > 0.25f || image.moved_m > 0.1f * voxel_m) {}

  /// The pose for a first look: the middle of the scan's.
  NodePose first_pose() const {
    return {&image.poses[projection.num_columns / 2], has_seam_ ? 1.0f : 0.0f};
  }

  /// The pose for looking into a child: that of the column which looks at its middle, as its parent's look told.
  NodePose pose_for(const NodeViews& views, int child, int edge) const {
    if (!has_seam_) return {&image.poses.front(), 0};
    const float radius_m = kHalfDiagonal * static_cast<float>(edge) * voxel_m;
    const int column = static_cast<int>(std::floor(views.column[child])) & column_mask;
    const RangeImage::ColumnPose* pose = &image.poses[column];
    if (views.axis_m[child] < 2 * radius_m) return {pose, 1};
    const float reach = radius_m / (views.axis_m[child] - radius_m) * columns_per_rad_;
    const float columns = static_cast<float>(projection.num_columns);
    // Wider than the node: how far the column may be off for being told from the parent's pose, and the columns that
    // the rows' shifts carry over the seam.
    const float zone = reach + static_cast<float>(projection.max_shift + 1) +
                       (image.turned_rad + image.moved_m / views.axis_m[child]) * columns_per_rad_;
    if (static_cast<float>(column) < zone || static_cast<float>(column) > columns - zone)
      return {pose, 1};
    return {pose, std::min(1.0f, 4 * reach / columns)};
  }

  /// Fractional row by the sine of the elevation.
  template <class V>
  HWY_INLINE V row_at(V sine, V& slope) const {
    const Lanes8 d;
    const Ints8 di;
    constexpr float kSteps = SphericalProjection::kSineSteps;
    const V place =
        hn::Min(hn::Max((sine + hn::Set(d, 1.0f)) * hn::Set(d, 0.5f * kSteps), hn::Zero(d)),
                hn::Set(d, kSteps));
    const auto index = hn::ConvertTo(di, place);
    const V lower = hn::GatherIndex(d, projection.row_of_sine.data(), index);
    const V upper = hn::GatherIndex(d, projection.row_of_sine.data() + 1, index);
    const V rise = upper - lower;
    slope = rise * hn::Set(d, 0.5f * kSteps);
    return lower + rise * (place - hn::ConvertTo(d, index));
  }

  /// The same for one place, to within the table.
  float row_of(float sine) const {
    constexpr float kSteps = SphericalProjection::kSineSteps;
    return projection.row_of_sine[static_cast<std::size_t>(
        std::clamp(0.5f * (sine + 1) * kSteps, 0.0f, kSteps))];
  }

  /// Projects the eight children of a node and holds them against the image's bounds.
  void view_children(const VoxelCoord& corner, int child_edge, const NodePose& from,
                     NodeViews& views) const {
    const Lanes8 d;
    const Ints8 di;
    using V = hn::Vec<Lanes8>;
    using VI = hn::Vec<Ints8>;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const RangeImage::ColumnPose& pose = *from.pose;
    const float edge_m = static_cast<float>(child_edge) * voxel_m;
    const float middle = 0.5f * static_cast<float>(child_edge);
    const auto first = [&](int axis) {
      return (static_cast<float>(corner[axis]) + middle) * voxel_m - pose.t_S[axis];
    };
    const float first_x = first(0), first_y = first(1), first_z = first(2);
    // Half the distance between the outermost voxel centres: what lies beyond them is not asked.
    const float half_m = 0.5f * static_cast<float>(child_edge - 1) * voxel_m;
    const V half = hn::Set(d, half_m), radius = hn::Set(d, 2 * kHalfDiagonal * half_m);
    const V turned = hn::Set(d, from.share * image.turned_rad),
            moved = hn::Set(d, from.share * image.moved_m);
    HWY_ALIGN static constexpr float kX[8] = {0, 1, 0, 1, 0, 1, 0, 1};
    HWY_ALIGN static constexpr float kY[8] = {0, 0, 1, 1, 0, 0, 1, 1};
    HWY_ALIGN static constexpr float kZ[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    views.free = views.mixed = views.gaps = 0;
    for (int lane = 0; lane < 8; lane += static_cast<int>(hn::Lanes(d))) {
      const V px = hn::Load(d, kX + lane) * hn::Set(d, edge_m) + hn::Set(d, first_x);
      const V py = hn::Load(d, kY + lane) * hn::Set(d, edge_m) + hn::Set(d, first_y);
      const V pz = hn::Load(d, kZ + lane) * hn::Set(d, edge_m) + hn::Set(d, first_z);
      const auto rotate = [&](int i) HWY_ATTR {
        return hn::Set(d, pose.R_L_S[i][0]) * px + hn::Set(d, pose.R_L_S[i][1]) * py +
               hn::Set(d, pose.R_L_S[i][2]) * pz;
      };
      const V x = rotate(0), y = rotate(1), z = rotate(2) - hn::Set(d, projection.ring_height_m);
      const V axis = hn::Max(hn::Sqrt(x * x + y * y), hn::Set(d, 1e-3f));
      const V rho = axis - hn::Set(d, projection.ring_radius_m);
      const V distance = hn::Max(hn::Sqrt(rho * rho + z * z), hn::Set(d, 1e-3f));
      const V per_axis = one / axis, per_distance = one / distance;
      const V cos_around = x * per_axis, sin_around = y * per_axis;
      const V cos_up = rho * per_distance, sin_up = z * per_distance;

      // Directions of rising distance, azimuth and elevation, along S's axes.
      V away[3], around[3], up[3];
      V away_norm = zero, around_norm = zero, up_norm = zero;
      for (int i = 0; i < 3; ++i) {
        const V rx = hn::Set(d, pose.R_L_S[0][i]), ry = hn::Set(d, pose.R_L_S[1][i]),
                rz = hn::Set(d, pose.R_L_S[2][i]);
        const V level = rx * cos_around + ry * sin_around;
        away[i] = level * cos_up + rz * sin_up;
        around[i] = ry * cos_around - rx * sin_around;
        up[i] = rz * cos_up - level * sin_up;
        away_norm = away_norm + hn::Abs(away[i]);
        around_norm = around_norm + hn::Abs(around[i]);
        up_norm = up_norm + hn::Abs(up[i]);
      }
      V row_slope;
      const V row = row_at(sin_up, row_slope);
      const V per_rad = hn::Set(d, projection.columns_per_rad);
      const V column = (azimuth(d, y, x) - hn::Set(d, projection.azimuth0_rad)) * per_rad;
      hn::Store(column, d, views.column + lane);
      hn::Store(row, d, views.row + lane);
      hn::Store(row_slope, d, views.rows_per_sine + lane);
      hn::Store(sin_up, d, views.sine + lane);
      hn::Store(distance, d, views.distance_m + lane);
      hn::Store(axis, d, views.axis_m + lane);
      const V voxel = hn::Set(d, voxel_m);
      const V column_scale = voxel * per_axis * per_rad;
      const V sine_scale = voxel * per_distance * hn::Abs(cos_up);
      for (int i = 0; i < 3; ++i) {
        hn::Store(around[i] * column_scale, d, views.column_step[i] + lane);
        hn::Store(up[i] * sine_scale, d, views.sine_step[i] + lane);
        hn::Store(away[i] * voxel, d, views.distance_step[i] + lane);
      }

      // Bounds of the node in the image. Too near, its width is no angle any more.
      const V near_axis = radius * per_axis, near = radius * per_distance;
      const V half_limit = hn::Set(d, 0.5f);
      const auto is_near = hn::Or(near_axis > half_limit, near > half_limit);
      const V drift = turned + moved * per_axis;
      const V slack = hn::Set(d, kAngleSlack);
      const V width =
          (half * around_norm * per_axis / (one - hn::Min(near_axis, half_limit)) + drift) *
              hn::Set(d, columns_per_rad_) +
          slack;
      const V height = (half * up_norm * per_distance / (one - hn::Min(near, half_limit)) +
                        near * near + drift) *
                           hn::Set(d, projection.max_rows_per_rad) +
                       slack;
      const V nearest = distance - half * away_norm - moved;
      const V furthest =
          distance + half * away_norm + hn::Set(d, 0.5f) * radius * radius * per_distance + moved;

      const V top = hn::Floor(row - height), bottom = hn::Ceil(row + height);
      const V left = hn::Floor(column - width), right = hn::Ceil(column + width);
      const V last_row = hn::Set(d, static_cast<float>(projection.num_rows() - 1));
      const auto is_outside = hn::Or(bottom<zero, top> last_row);
      const auto is_inside = hn::And(top >= zero, bottom <= last_row);
      const VI row0 = hn::ConvertTo(di, hn::Min(hn::Max(top, zero), last_row));
      const VI row1 = hn::ConvertTo(di, hn::Min(hn::Max(bottom, zero), last_row));
      const VI column0 = hn::ConvertTo(di, left), column1 = hn::ConvertTo(di, right);

      // The level at which the rectangle lies within 2 x 2 cells: cells at least as long as its sides.
      const V rows = hn::ConvertTo(d, row1 - row0);
      const V columns =
          (right - left) * hn::Set(d, 1.0f / static_cast<float>(1 << projection.squaring));
      const V side = hn::Max(hn::Max(rows, hn::Ceil(columns)) - one, zero);
      // ceil(log2(side + 1)) by the exponent of a float: exact for whole numbers below 2^24.
      const VI exponent = hn::ShiftRight<23>(hn::BitCast(di, side)) - hn::Set(di, 126);
      const VI level = hn::Max(exponent, hn::Zero(di));
      const auto is_wide = hn::RebindMask(d, level > hn::Set(di, image.num_levels - 1));
      const VI cell_level = hn::Min(level, hn::Set(di, image.num_levels - 1));
      HWY_ALIGN std::int32_t levels[8], tops[8], bottoms[8], lefts[8], rights[8];
      hn::Store(cell_level, di, levels);
      hn::Store(row0, di, tops);
      hn::Store(row1, di, bottoms);
      hn::Store(column0, di, lefts);
      hn::Store(column1, di, rights);
      // Bounds of four cells at once: the least of all, and the most of all.
      const hn::CappedTag<std::uint16_t, 4> du;
      HWY_ALIGN float least[8], most[8], most_gap[8];
      for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
        const int k = levels[i];
        const int shift = k + projection.squaring;
        const int cells = projection.num_columns >> shift;
        const RangeImage::Bounds* cell = image.pyramid.data() + image.level_begin[k];
        const RangeImage::Bounds* upper = cell + (tops[i] >> k) * cells;
        const RangeImage::Bounds* lower = cell + (bottoms[i] >> k) * cells;
        const int c0 = (lefts[i] >> shift) & (cells - 1), c1 = (rights[i] >> shift) & (cells - 1);
        HWY_ALIGN std::uint16_t low[4] = {}, high[4] = {};
        for (std::size_t j = 0; j < 4; j += hn::Lanes(du)) {
          const auto at_cell = [&](const RangeImage::Bounds& bounds)
                                   HWY_ATTR { return hn::LoadU(du, &bounds.least + j); };
          const auto e0 = at_cell(upper[c0]), e1 = at_cell(upper[c1]), e2 = at_cell(lower[c0]),
                     e3 = at_cell(lower[c1]);
          hn::Store(hn::Min(hn::Min(e0, e1), hn::Min(e2, e3)), du, low + j);
          hn::Store(hn::Max(hn::Max(e0, e1), hn::Max(e2, e3)), du, high + j);
        }
        least[i] = low[0];
        most[i] = high[1];
        most_gap[i] = high[2];
      }
      const V unit = hn::Set(d, image.unit_m);
      const V least_m = hn::Load(d, least) * unit, most_m = hn::Load(d, most) * unit;
      const V most_gap_m = hn::Load(d, most_gap) * unit;

      const auto is_unbounded = hn::Or(is_near, is_wide);
      const auto is_unseen = hn::Or(nearest > hn::Set(d, max_range_m_),
                                    hn::AndNot(is_unbounded, hn::Or(is_outside, most_m < nearest)));
      const auto is_free = hn::AndNot(is_unbounded, hn::And(is_inside, least_m >= furthest));
      views.free |= mask_bits(d, hn::AndNot(is_unseen, is_free)) << lane;
      views.mixed |= mask_bits(d, hn::Not(hn::Or(is_unseen, is_free))) << lane;
      views.gaps |= mask_bits(d, hn::Or(is_unbounded, most_gap_m >= nearest)) << lane;
    }
  }

  const RangeImage& image;
  const SphericalProjection& projection;
  const float voxel_m;
  const int column_mask;  ///< takes any column into the image

 private:
  float max_range_m_;
  float columns_per_rad_;  ///< without its sign
  bool has_seam_;          ///< beginning and end of the scan do not see the same
};

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
