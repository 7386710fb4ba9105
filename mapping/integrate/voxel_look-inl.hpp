// What a range image says about voxels, compiled once for each instruction set (see block_update-inl.hpp).
#if defined(CLOISTER_VOXEL_LOOK_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef CLOISTER_VOXEL_LOOK_INL_HPP
#undef CLOISTER_VOXEL_LOOK_INL_HPP
#else
#define CLOISTER_VOXEL_LOOK_INL_HPP
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <hwy/highway.h>

#include "mapping/integrate/node_views-inl.hpp"
#include "mapping/integrate/scan_marks.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// What lies nearer than the middle of a node that is looked up from there is seen under an angle larger by up to this.
constexpr float kShrinkSlack = 1.1f;
// How far a voxel reaches from its centre, and a little more for what a linear projection is wrong by.
constexpr float kReach = 0.505f;
// Half a pixel and a fifth more: the nearest beam alone may see through voxels that reach further than this.
constexpr float kWideReach = 0.6f;

/// Sixteen places around the middle of a node, voxels.
struct Offsets {
  HWY_ALIGN float x[16], y[16], z[16];
};

/// A rectangle of voxel centres, x fastest, around (x, y).
constexpr Offsets rectangle(int width, float x, float y) {
  Offsets offsets{};
  const int height = 16 / width;
  for (int i = 0; i < 16; ++i) {
    offsets.x[i] = x + static_cast<float>(i % width) - 0.5f * static_cast<float>(width - 1);
    offsets.y[i] = y + static_cast<float>(i / width) - 0.5f * static_cast<float>(height - 1);
  }
  return offsets;
}
constexpr Offsets octant_middles() {
  Offsets offsets{};
  for (int i = 0; i < 16; ++i) {
    offsets.x[i] = (i & 1) != 0 ? 2.0f : -2.0f;
    offsets.y[i] = (i & 2) != 0 ? 2.0f : -2.0f;
    offsets.z[i] = (i & 4) != 0 ? 2.0f : -2.0f;
  }
  return offsets;
}
constexpr Offsets kOctantSlice = rectangle(4, 0, 0);  ///< of an octant, around its own middle
constexpr Offsets kOctantSlices[4] = {
    rectangle(4, -2, -2), rectangle(4, 2, -2), rectangle(4, -2, 2),
    rectangle(4, 2, 2)};  ///< of a block's octants, around the block's middle
constexpr Offsets kRowPairs[4] = {rectangle(8, 0, -3), rectangle(8, 0, -1), rectangle(8, 0, 1),
                                  rectangle(8, 0, 3)};
constexpr Offsets kOctantMiddles = octant_middles();

/// Columns of the image that belong to a pose.
struct ColumnWindow {
  int first;
  int end;
  bool is_seam;  ///< others belong to another pose
};

/// For nodes that one pose sees as a whole; a row is shorter than this.
constexpr ColumnWindow kWhole{0, 1 << 24, false};

/// Of sixteen voxels.
struct SliceBits {
  std::uint32_t free;
  std::uint32_t crossed;  ///< by beams that clear what is occupied
};

using Voxels16 = hn::CappedTag<float, 16>;

/// Pixels around an octant, in registers where they are few: a gather costs as much as all the rest of a look-up.
class PixelWindow {
 public:
  using D = Voxels16;
  using DI = hn::RebindToSigned<D>;
  static constexpr int kRows = 4, kColumns = 8;

  /// @param reach_*  how far from the view's middle its voxels lie to either side
  PixelWindow(const NodeProjector& from, const LinearView& view, float column_reach,
              float sine_reach)
      : stride_(from.image.stride), mask_(from.column_mask) {
    const auto& rows = from.projection.rows;
    const int num_rows = from.projection.num_rows();
    column0_ = static_cast<int>(std::floor(view.column - column_reach));
    // The rows above and below all of it; further apart than the window, the search is over.
    const int middle = std::clamp(static_cast<int>(view.row), 0, num_rows - 1);
    int upper = middle, lower = middle;
    while (upper > 0 && upper > middle - kRows &&
           rows[upper].sin_elevation < view.sine + sine_reach)
      --upper;
    while (lower + 1 < num_rows && lower < upper + kRows &&
           rows[lower].sin_elevation > view.sine - sine_reach)
      ++lower;
    fits_ = num_rows >= kRows && lower < upper + kRows &&
            static_cast<int>(std::floor(view.column + column_reach + 0.5f)) < column0_ + kColumns;
    row0_ = std::clamp(upper, 0, std::max(num_rows - kRows, 0));
  }

  [[nodiscard]] bool fits() const { return fits_; }
  [[nodiscard]] int row0() const { return row0_; }

  /// Makes ready to look into one image. [rows x stride]
  void load(const float* pixels) {
    pixels_ = pixels;
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
    if (!fits_) return;
    const D d;
    const float* first = pixels + static_cast<std::ptrdiff_t>(row0_) * stride_ + (column0_ & mask_);
    for (int i = 0; i < kTables; ++i) {
#if HWY_MAX_BYTES >= 64
      const hn::CappedTag<float, kColumns> half;
      const float* row = first + 2 * i * stride_;
      table_[i] = hn::Combine(d, hn::LoadU(half, row + stride_), hn::LoadU(half, row));
#else
      table_[i] = hn::LoadU(d, first + i * stride_);
#endif
    }
#endif
  }

  /// Pixels by row, inside the image, and column, anywhere.
  HWY_INLINE hn::Vec<D> at(hn::Vec<DI> row, hn::Vec<DI> column) const {
    const D d;
    const DI di;
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
    if (fits_) {
      const auto index =
          hn::ShiftLeft<3>(row - hn::Set(di, row0_)) + (column - hn::Set(di, column0_));
      const auto lane =
          hn::IndicesFromVec(d, index & hn::Set(di, static_cast<int>(hn::Lanes(d)) - 1));
      auto value = hn::TableLookupLanes(table_[0], lane);
      for (int i = 1; i < kTables; ++i) {
        const auto is_here =
            hn::RebindMask(d, index > hn::Set(di, i * static_cast<int>(hn::Lanes(d)) - 1));
        value = hn::IfThenElse(is_here, hn::TableLookupLanes(table_[i], lane), value);
      }
      return value;
    }
#endif
    return hn::GatherIndex(d, pixels_, row * hn::Set(di, stride_) + (column & hn::Set(di, mask_)));
  }

 private:
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
  static constexpr int kTables = kRows * kColumns / static_cast<int>(HWY_MAX_BYTES >= 64 ? 16 : 8);
  hn::Vec<D> table_[kTables];
#endif
  const float* pixels_ = nullptr;
  int row0_, column0_, stride_, mask_;
  bool fits_;
};

/// Looks up voxels around the middle of a node, sixteen at a time, the projection being linear there.
class VoxelLook {
 public:
  /// @param reach_voxels  how far from the middle voxels may be along each axis
  /// @param has_occupied  which beams have crossed its voxels matters
  VoxelLook(const NodeProjector& from, const LinearView& view, float reach_voxels,
            bool has_occupied)
      : from_(from),
        view_(view),
        per_distance_(1 / view.distance_m),
        beams_(from, view, reach(view.column_step, reach_voxels) + kAngleSlack,
               reach(view.sine_step, reach_voxels)),
        gaps_(beams_) {
    // As far as a voxel reaches from its centre, in columns and by the sine of the elevation: no beam that hits it passes
    // further off.
    column_reach_ = kReach * extent(view.column_step);
    sine_reach_ = kReach * extent(view.sine_step);
    // Where voxels are wider than the image's cells some beam crosses each of them, and not only at a corner; elsewhere
    // the gaps tell.
    asks_gaps_ =
        column_reach_ < kWideReach || sine_reach_ * std::abs(view.rows_per_sine) < kWideReach;
    asks_beams_ = has_occupied || !asks_gaps_;
    // Across many rows, the spacing that they have on the whole.
    const float sine_reach = reach(view.sine_step, reach_voxels);
    rows_per_sine_ =
        beams_.fits()
            ? view.rows_per_sine
            : (from.row_of(view.sine + sine_reach) - from.row_of(view.sine - sine_reach)) /
                  (2 * sine_reach);
    if (asks_beams_) beams_.load(from.image.free_m.data());
    if (asks_gaps_) gaps_.load(from.image.gap_free_m.data());
  }

  /// Are all its pixels in registers?
  [[nodiscard]] bool fits() const { return beams_.fits(); }

  /// @param offsets  from the middle, voxels @param dz  added to all of them
  HWY_INLINE SliceBits at(const Offsets& offsets, float dz, const ColumnWindow& window) const {
    const Voxels16 d;
    using V = hn::Vec<Voxels16>;
    SliceBits bits{0, 0};
    for (int lane = 0; lane < 16; lane += static_cast<int>(hn::Lanes(d))) {
      const V dx = hn::Load(d, offsets.x + lane), dy = hn::Load(d, offsets.y + lane);
      const V z = hn::Load(d, offsets.z + lane) + hn::Set(d, dz);
      const auto along = [&](const float(&step)[3]) HWY_ATTR {
        return hn::Set(d, step[0]) * dx + hn::Set(d, step[1]) * dy + hn::Set(d, step[2]) * z;
      };
      // To second order: what lies further away is seen under a smaller angle, and what lies aside is further away.
      const V away = along(view_.distance_step);
      const V shrunk = hn::Set(d, 1.0f) - away * hn::Set(d, per_distance_);
      const V aside =
          (dx * dx + dy * dy + z * z) * hn::Set(d, from_.voxel_m * from_.voxel_m) - away * away;
      const SliceBits some = judge(
          hn::Set(d, view_.column) + along(view_.column_step) * shrunk,
          hn::Set(d, view_.sine) + along(view_.sine_step) * shrunk,
          hn::Set(d, view_.distance_m) + away + aside * hn::Set(d, 0.5f * per_distance_), window);
      bits.free |= some.free << lane;
      bits.crossed |= some.crossed << lane;
    }
    return bits;
  }

  /// All voxels of a block around the middle, to first order: for one that is far away.
  HWY_INLINE void at_block(BlockBits& free, BlockBits& crossed) const {
    const Voxels16 d;
    using V = hn::Vec<Voxels16>;
    for (int pair = 0; pair < 4; ++pair) {
      for (int lane = 0; lane < 16; lane += static_cast<int>(hn::Lanes(d))) {
        const V dx = hn::Load(d, kRowPairs[pair].x + lane),
                dy = hn::Load(d, kRowPairs[pair].y + lane);
        const auto place = [&](float middle, const float(&step)[3]) HWY_ATTR {
          return hn::Set(d, middle) + hn::Set(d, step[0]) * dx + hn::Set(d, step[1]) * dy;
        };
        const V column = place(view_.column, view_.column_step),
                sine = place(view_.sine, view_.sine_step);
        const V distance = place(view_.distance_m, view_.distance_step);
        for (int z = 0; z < kBlockEdge; ++z) {
          const float dz = static_cast<float>(z) - 0.5f * (kBlockEdge - 1);
          const SliceBits bits = judge(column + hn::Set(d, view_.column_step[2] * dz),
                                       sine + hn::Set(d, view_.sine_step[2] * dz),
                                       distance + hn::Set(d, view_.distance_step[2] * dz), kWhole);
          free.word[z] |= std::uint64_t{bits.free} << (16 * pair + lane);
          crossed.word[z] |= std::uint64_t{bits.crossed} << (16 * pair + lane);
        }
      }
    }
  }

 private:
  /// Of a cube of one voxel, across the image.
  static float extent(const float (&step)[3]) {
    return std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
  }
  /// How far from the middle the outermost voxels lie.
  static float reach(const float (&step)[3], float reach_voxels) {
    return kShrinkSlack * reach_voxels * extent(step);
  }

  /// Does a pixel prove more than a distance? One that was fired at the other end of the scan belongs to the other pose.
  HWY_INLINE hn::Mask<Voxels16> is_proven(hn::Vec<Voxels16> proven,
                                          hn::Vec<hn::RebindToSigned<Voxels16>> column,
                                          hn::Vec<Voxels16> distance,
                                          const ColumnWindow& window) const {
    if (!window.is_seam) return proven >= distance;
    const Voxels16 d;
    const hn::RebindToSigned<Voxels16> di;
    const auto wrapped = column & hn::Set(di, from_.column_mask);
    const auto is_inside = hn::RebindMask(
        d, hn::And(wrapped > hn::Set(di, window.first - 1), wrapped < hn::Set(di, window.end)));
    return hn::And(hn::Xor(is_inside, proven < hn::Zero(d)), hn::Abs(proven) >= distance);
  }

  /// What is known of as many places as a vector has lanes.
  HWY_INLINE SliceBits judge(hn::Vec<Voxels16> column, hn::Vec<Voxels16> sine,
                             hn::Vec<Voxels16> distance, const ColumnWindow& window) const {
    const Voxels16 d;
    const hn::RebindToSigned<Voxels16> di;
    using V = hn::Vec<Voxels16>;
    const Rows rows = rows_at(sine);
    unsigned crossed = 0, filled = 0;
    if (asks_beams_) {
      const V beam_column = hn::Round(column);
      const auto is_near = hn::And(hn::Abs(sine - rows.beam_sine) <= hn::Set(d, sine_reach_),
                                   hn::Abs(column - beam_column) <= hn::Set(d, column_reach_));
      const auto index = hn::ConvertTo(di, beam_column);
      crossed = mask_bits(
          d, hn::And(is_near, is_proven(beams_.at(rows.beam, index), index, distance, window)));
    }
    if (asks_gaps_) {
      const auto& beams = from_.projection.rows;
      const auto is_between = hn::And(sine <= hn::Set(d, beams.front().sin_elevation),
                                      sine > hn::Set(d, beams.back().sin_elevation));
      const auto index = hn::ConvertTo(di, hn::Floor(column));
      filled = mask_bits(
          d, hn::And(is_between, is_proven(gaps_.at(rows.gap, index), index, distance, window)));
    }
    // Where beams are further apart than voxels, one alone may be skimming the voxel's surface.
    return {crossed | filled, asks_gaps_ ? crossed & filled : crossed};
  }

  /// Rows of the image by the sine of an elevation: the nearest beam's, and the one above.
  struct Rows {
    hn::Vec<hn::RebindToSigned<Voxels16>> beam, gap;
    hn::Vec<Voxels16> beam_sine;
  };
  HWY_INLINE Rows rows_at(hn::Vec<Voxels16> sine) const {
    const Voxels16 d;
    const hn::RebindToSigned<Voxels16> di;
    const auto& rows = from_.projection.rows;
    const auto one = hn::Set(di, 1), zero = hn::Zero(di);
    Rows found{zero, zero, hn::Zero(d)};
    if (beams_.fits()) {
      const auto* row = &rows[beams_.row0()];
      found.beam = found.gap = hn::Set(di, beams_.row0());
      found.beam_sine = hn::Set(d, row->sin_elevation);
      for (int i = 1; i < PixelWindow::kRows; ++i, ++row) {
        const float upper = row->sin_elevation, lower = row[1].sin_elevation;
        const auto is_lower = sine < hn::Set(d, 0.5f * (upper + lower));
        found.beam = found.beam + hn::IfThenElse(hn::RebindMask(di, is_lower), one, zero);
        found.beam_sine = hn::IfThenElse(is_lower, hn::Set(d, lower), found.beam_sine);
        found.gap =
            found.gap + hn::IfThenElse(hn::RebindMask(di, sine <= hn::Set(d, lower)), one, zero);
      }
      return found;
    }
    const auto row =
        hn::Set(d, view_.row) + (sine - hn::Set(d, view_.sine)) * hn::Set(d, rows_per_sine_);
    const auto last_row = hn::Set(d, static_cast<float>(from_.projection.num_rows() - 1));
    const auto beam = hn::Min(hn::Max(hn::Round(row), hn::Zero(d)), last_row);
    found.beam = hn::ConvertTo(di, beam);
    found.gap = hn::ConvertTo(di, hn::Min(hn::Max(hn::Floor(row), hn::Zero(d)), last_row));
    found.beam_sine = sine + (beam - row) * hn::Set(d, 1 / rows_per_sine_);
    return found;
  }

  const NodeProjector& from_;
  const LinearView view_;
  float per_distance_;
  PixelWindow beams_;
  PixelWindow gaps_;
  float column_reach_;
  float sine_reach_;
  float rows_per_sine_;
  bool asks_gaps_;
  bool asks_beams_;
};

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
