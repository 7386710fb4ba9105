#include "mapping/integrate/projective.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrate/projective.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "mapping/integrate/block_update-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kRootEdge = 512;  // voxels
constexpr int kChunkVoxels = kBlockEdge * kChunkEdge;
constexpr float kHalfDiagonal = 0.8660254f;  // of a cube of edge 1
// What lies nearer than the middle of a node that is looked up from there is seen under an angle larger by up to this.
constexpr float kShrinkSlack = 1.1f;
// What rounding may be wrong by, in columns or rows.
constexpr float kAngleSlack = 0.01f;

// Blocks nearer than this are looked up octant by octant: across them the projection bends too much.
constexpr float kMinFarVoxels = 200;
// Nearer than this, not even where an octant's middle is seen can be told from the block's own view.
constexpr float kMinLookVoxels = 40;

// Of an octant's 64, for it to be free as a whole all the same.
constexpr int kMaxUnseenVoxels = 16;

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

/// Sixteen places around the middle of a node, voxels.
struct Offsets {
  HWY_ALIGN float x[16], y[16], z[16];
};

/// A rectangle of voxel centres, x fastest, around (x, y).
constexpr Offsets Rectangle(int width, float x, float y) {
  Offsets offsets{};
  const int height = 16 / width;
  for (int i = 0; i < 16; ++i) {
    offsets.x[i] = x + static_cast<float>(i % width) - 0.5f * static_cast<float>(width - 1);
    offsets.y[i] = y + static_cast<float>(i / width) - 0.5f * static_cast<float>(height - 1);
  }
  return offsets;
}
constexpr Offsets OctantMiddles() {
  Offsets offsets{};
  for (int i = 0; i < 16; ++i) {
    offsets.x[i] = (i & 1) != 0 ? 2.0f : -2.0f;
    offsets.y[i] = (i & 2) != 0 ? 2.0f : -2.0f;
    offsets.z[i] = (i & 4) != 0 ? 2.0f : -2.0f;
  }
  return offsets;
}
constexpr Offsets kOctantSlice = Rectangle(4, 0, 0);  ///< of an octant, around its own middle
constexpr Offsets kOctantSlices[4] = {Rectangle(4, -2, -2), Rectangle(4, 2, -2), Rectangle(4, -2, 2),
                                      Rectangle(4, 2, 2)};  ///< of a block's octants, around the block's middle
constexpr Offsets kRowPairs[4] = {Rectangle(8, 0, -3), Rectangle(8, 0, -1), Rectangle(8, 0, 1), Rectangle(8, 0, 3)};
constexpr Offsets kOctantMiddles = OctantMiddles();
constexpr int kWholeNode = -1;

/// Columns of the image that belong to a pose.
struct ColumnWindow {
  int first;
  int end;
  bool is_seam;  ///< others belong to another pose
};

/// For nodes that one pose sees as a whole; a row is shorter than this.
constexpr ColumnWindow kWhole{0, 1 << 24, false};

/// Arc tangent of y / x in all four quadrants, to 1e-5 rad (Abramowitz and Stegun, 4.4.47).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V Azimuth(D d, V y, V x) {
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

class Carver {
 public:
  explicit Carver(const ProjectiveJob& job)
      : image_(job.image),
        projection_(*job.image.projection),
        evidence_(job.evidence),
        twice_free_(job.evidence),
        scan_number_(job.scan_number),
        marks_(job.marks),
        pools_(job.pools),
        volume_(job.volume),
        voxel_m_(static_cast<float>(job.voxel_size_m)),
        max_range_m_(static_cast<float>(job.max_range_m)),
        last_row_(static_cast<float>(projection_.num_rows() - 1)),
        columns_per_rad_(std::abs(projection_.columns_per_rad)),
        column_mask_(projection_.num_columns - 1) {
    // The seam matters where a beam's share of it is larger than the columns' spacing, or than a tenth of a voxel.
    twice_free_.miss = static_cast<LogOdds>(2 * std::max<int>(evidence_.miss, -63));
    is_first_ = volume_.num_chunks() == 0;
    sparse_m_ = voxel_m_ * projection_.max_rows_per_rad;
    has_seam_ = image_.turned_rad * columns_per_rad_ > 0.25f || image_.moved_m > 0.1f * voxel_m_;
  }

  ProjectiveResult Run() {
    const Eigen::Vector3f sensor_S = image_.poses[projection_.num_columns / 2].t_S;
    const float reach_m = max_range_m_ + image_.moved_m;
    VoxelCoord low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = static_cast<int>(std::floor((sensor_S[a] - reach_m) / voxel_m_)) & ~(kRootEdge - 1);
      high[a] = static_cast<int>(std::floor((sensor_S[a] + reach_m) / voxel_m_));
    }
    const NodePose from{&image_.poses[projection_.num_columns / 2], has_seam_ ? 1.0f : 0.0f};
    for (int z = low.z(); z <= high.z(); z += kRootEdge) {
      for (int y = low.y(); y <= high.y(); y += kRootEdge) {
        for (int x = low.x(); x <= high.x(); x += kRootEdge) Divide({x, y, z}, kRootEdge, from);
      }
    }
    return result_;
  }

 private:
  class VoxelLook;

  // ---- Projection ----

  /// The pose for looking into a child: that of the column which looks at its middle, as its parent's look told.
  NodePose PoseFor(const NodeViews& views, int child, int edge) const {
    if (!has_seam_) return {&image_.poses.front(), 0};
    const float radius_m = kHalfDiagonal * static_cast<float>(edge) * voxel_m_;
    const int column = static_cast<int>(std::floor(views.column[child])) & column_mask_;
    const RangeImage::ColumnPose* pose = &image_.poses[column];
    if (views.axis_m[child] < 2 * radius_m) return {pose, 1};
    const float reach = radius_m / (views.axis_m[child] - radius_m) * columns_per_rad_;
    const float columns = static_cast<float>(projection_.num_columns);
    // Wider than the node: how far the column may be off for being told from the parent's pose, and the columns that
    // the rows' shifts carry over the seam.
    const float zone = reach + static_cast<float>(projection_.max_shift + 1) +
                       (image_.turned_rad + image_.moved_m / views.axis_m[child]) * columns_per_rad_;
    if (static_cast<float>(column) < zone || static_cast<float>(column) > columns - zone) return {pose, 1};
    return {pose, std::min(1.0f, 4 * reach / columns)};
  }

  /// Fractional row by the sine of the elevation.
  template <class V>
  HWY_INLINE V RowAt(V sine, V& slope) const {
    const Lanes8 d;
    const Ints8 di;
    constexpr float kSteps = SphericalProjection::kSineSteps;
    const V place = hn::Min(hn::Max((sine + hn::Set(d, 1.0f)) * hn::Set(d, 0.5f * kSteps), hn::Zero(d)),
                            hn::Set(d, kSteps));
    const auto index = hn::ConvertTo(di, place);
    const V lower = hn::GatherIndex(d, projection_.row_of_sine.data(), index);
    const V upper = hn::GatherIndex(d, projection_.row_of_sine.data() + 1, index);
    const V rise = upper - lower;
    slope = rise * hn::Set(d, 0.5f * kSteps);
    return lower + rise * (place - hn::ConvertTo(d, index));
  }

  float RowOf(float sine) const {
    constexpr float kSteps = SphericalProjection::kSineSteps;
    return projection_.row_of_sine[static_cast<std::size_t>(std::clamp(0.5f * (sine + 1) * kSteps, 0.0f, kSteps))];
  }

  /// Projects the eight children of a node and holds them against the image's bounds.
  void ViewChildren(const VoxelCoord& corner, int child_edge, const NodePose& from, NodeViews& views) const {
    const Lanes8 d;
    const Ints8 di;
    using V = hn::Vec<Lanes8>;
    using VI = hn::Vec<Ints8>;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const RangeImage::ColumnPose& pose = *from.pose;
    const float edge_m = static_cast<float>(child_edge) * voxel_m_;
    const float middle = 0.5f * static_cast<float>(child_edge);
    const auto first = [&](int axis) { return (static_cast<float>(corner[axis]) + middle) * voxel_m_ - pose.t_S[axis]; };
    const float first_x = first(0), first_y = first(1), first_z = first(2);
    // Half the distance between the outermost voxel centres: what lies beyond them is not asked.
    const float half_m = 0.5f * static_cast<float>(child_edge - 1) * voxel_m_;
    const V half = hn::Set(d, half_m), radius = hn::Set(d, 2 * kHalfDiagonal * half_m);
    const V turned = hn::Set(d, from.share * image_.turned_rad), moved = hn::Set(d, from.share * image_.moved_m);
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
      const V x = rotate(0), y = rotate(1), z = rotate(2) - hn::Set(d, projection_.ring_height_m);
      const V axis = hn::Max(hn::Sqrt(x * x + y * y), hn::Set(d, 1e-3f));
      const V rho = axis - hn::Set(d, projection_.ring_radius_m);
      const V distance = hn::Max(hn::Sqrt(rho * rho + z * z), hn::Set(d, 1e-3f));
      const V per_axis = one / axis, per_distance = one / distance;
      const V cos_around = x * per_axis, sin_around = y * per_axis;
      const V cos_up = rho * per_distance, sin_up = z * per_distance;

      // Directions of rising distance, azimuth and elevation, along S's axes.
      V away[3], around[3], up[3];
      V away_norm = zero, around_norm = zero, up_norm = zero;
      for (int i = 0; i < 3; ++i) {
        const V rx = hn::Set(d, pose.R_L_S[0][i]), ry = hn::Set(d, pose.R_L_S[1][i]), rz = hn::Set(d, pose.R_L_S[2][i]);
        const V level = rx * cos_around + ry * sin_around;
        away[i] = level * cos_up + rz * sin_up;
        around[i] = ry * cos_around - rx * sin_around;
        up[i] = rz * cos_up - level * sin_up;
        away_norm = away_norm + hn::Abs(away[i]);
        around_norm = around_norm + hn::Abs(around[i]);
        up_norm = up_norm + hn::Abs(up[i]);
      }
      V row_slope;
      const V row = RowAt(sin_up, row_slope);
      const V per_rad = hn::Set(d, projection_.columns_per_rad);
      const V column = (Azimuth(d, y, x) - hn::Set(d, projection_.azimuth0_rad)) * per_rad;
      hn::Store(column, d, views.column + lane);
      hn::Store(row, d, views.row + lane);
      hn::Store(row_slope, d, views.rows_per_sine + lane);
      hn::Store(sin_up, d, views.sine + lane);
      hn::Store(distance, d, views.distance_m + lane);
      hn::Store(axis, d, views.axis_m + lane);
      const V voxel = hn::Set(d, voxel_m_);
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
      const V width = (half * around_norm * per_axis / (one - hn::Min(near_axis, half_limit)) + drift) *
                          hn::Set(d, columns_per_rad_) + slack;
      const V height = (half * up_norm * per_distance / (one - hn::Min(near, half_limit)) + near * near + drift) *
                           hn::Set(d, projection_.max_rows_per_rad) + slack;
      const V nearest = distance - half * away_norm - moved;
      const V furthest = distance + half * away_norm + hn::Set(d, 0.5f) * radius * radius * per_distance + moved;

      const V top = hn::Floor(row - height), bottom = hn::Ceil(row + height);
      const V left = hn::Floor(column - width), right = hn::Ceil(column + width);
      const V last_row = hn::Set(d, last_row_);
      const auto is_outside = hn::Or(bottom < zero, top > last_row);
      const auto is_inside = hn::And(top >= zero, bottom <= last_row);
      const VI row0 = hn::ConvertTo(di, hn::Min(hn::Max(top, zero), last_row));
      const VI row1 = hn::ConvertTo(di, hn::Min(hn::Max(bottom, zero), last_row));
      const VI column0 = hn::ConvertTo(di, left), column1 = hn::ConvertTo(di, right);

      // The level at which the rectangle lies within 2 x 2 cells: cells at least as long as its sides.
      const V rows = hn::ConvertTo(d, row1 - row0);
      const V columns = (right - left) * hn::Set(d, 1.0f / static_cast<float>(1 << projection_.squaring));
      const V side = hn::Max(hn::Max(rows, hn::Ceil(columns)) - one, zero);
      // ceil(log2(side + 1)) by the exponent of a float: exact for whole numbers below 2^24.
      const VI exponent = hn::ShiftRight<23>(hn::BitCast(di, side)) - hn::Set(di, 126);
      const VI level = hn::Max(exponent, hn::Zero(di));
      const auto is_wide = hn::RebindMask(d, level > hn::Set(di, image_.num_levels - 1));
      const VI cell_level = hn::Min(level, hn::Set(di, image_.num_levels - 1));
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
        const int shift = k + projection_.squaring;
        const int cells = projection_.num_columns >> shift;
        const RangeImage::Bounds* cell = image_.pyramid.data() + image_.level_begin[k];
        const RangeImage::Bounds* upper = cell + (tops[i] >> k) * cells;
        const RangeImage::Bounds* lower = cell + (bottoms[i] >> k) * cells;
        const int c0 = (lefts[i] >> shift) & (cells - 1), c1 = (rights[i] >> shift) & (cells - 1);
        const auto e0 = hn::LoadU(du, &upper[c0].least), e1 = hn::LoadU(du, &upper[c1].least);
        const auto e2 = hn::LoadU(du, &lower[c0].least), e3 = hn::LoadU(du, &lower[c1].least);
        HWY_ALIGN std::uint16_t low[4] = {}, high[4] = {};
        hn::Store(hn::Min(hn::Min(e0, e1), hn::Min(e2, e3)), du, low);
        hn::Store(hn::Max(hn::Max(e0, e1), hn::Max(e2, e3)), du, high);
        least[i] = low[0];
        most[i] = high[1];
        most_gap[i] = high[2];
      }
      const V unit = hn::Set(d, image_.unit_m);
      const V least_m = hn::Load(d, least) * unit, most_m = hn::Load(d, most) * unit;
      const V most_gap_m = hn::Load(d, most_gap) * unit;

      const auto is_unbounded = hn::Or(is_near, is_wide);
      const auto is_unseen = hn::Or(nearest > hn::Set(d, max_range_m_),
                                    hn::AndNot(is_unbounded, hn::Or(is_outside, most_m < nearest)));
      const auto is_free = hn::AndNot(is_unbounded, hn::And(is_inside, least_m >= furthest));
      views.free |= Bits(d, hn::AndNot(is_unseen, is_free)) << lane;
      views.mixed |= Bits(d, hn::Not(hn::Or(is_unseen, is_free))) << lane;
      views.gaps |= Bits(d, hn::Or(is_unbounded, most_gap_m >= nearest)) << lane;
    }
  }

  template <class D, class M>
  static HWY_INLINE unsigned Bits(D d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return bytes[0];
  }

  // ---- From coarse to fine ----

  static VoxelCoord ChildCorner(const VoxelCoord& corner, int edge, int child) {
    return corner + VoxelCoord((child & 1) * edge, ((child >> 1) & 1) * edge, (child >> 2) * edge);
  }

  void Divide(const VoxelCoord& corner, int edge, const NodePose& from) {
    if (edge == kChunkVoxels) EnterChunk(corner);
    const int child_edge = edge / 2;
    NodeViews views;
    ViewChildren(corner, child_edge, from, views);
    result_.nodes_tested += 8;
    // Only what is there already can be changed by beams that do not see through a node as a whole.
    const bool is_bare = edge <= kChunkVoxels && slots_ == nullptr && chunk_ == nullptr;
    const unsigned ask = views.free | (is_bare ? views.mixed & views.gaps : views.mixed);
    if (child_edge == kBlockEdge) FetchBlocks(corner, ask);
    for (unsigned rest = ask; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      const VoxelCoord child_corner = ChildCorner(corner, child_edge, child);
      const bool is_free = (views.free >> child) & 1;
      if (child_edge == kBlockEdge) {
        VisitBlock({child_corner, is_free, ((views.gaps >> child) & 1) != 0, &views, child, nullptr});
      } else if (is_free) {
        Free(child_corner, child_edge, PoseFor(views, child, child_edge));
      } else {
        Divide(child_corner, child_edge, PoseFor(views, child, child_edge));
      }
    }
  }

  /// Calls for the memory of children that will be visited: it arrives while the first of them are looked up.
  void FetchBlocks(const VoxelCoord& corner, unsigned children) const {
    if (chunk_ == nullptr) return;
    for (unsigned rest = children; rest != 0; rest &= rest - 1) {
      const BlockCoord block = parent_coord(ChildCorner(corner, kBlockEdge, std::countr_zero(rest)));
      const std::uint32_t place = chunk_->places[index_in_block(block)];
      if (!Volume::has_block(place)) continue;
      const LogOdds* voxels = pools_.store.block(Volume::block_index(place)).voxels;
      for (int i = 0; i < kBlockVoxels; i += 64) __builtin_prefetch(voxels + i);
    }
  }

  /// Whatever follows concerns the chunk with this corner, until another is entered.
  void EnterChunk(const VoxelCoord& corner) {
    chunk_coord_ = parent_coord(parent_coord(corner));
    const PoolIndex index = volume_.find_chunk(pools_.store, chunk_coord_);
    chunk_ = index == kNoIndex ? nullptr : &pools_.store.chunk(index);
    slots_ = marks_.find_chunk(chunk_coord_);
  }

  bool MakeChunk() {
    if (chunk_ != nullptr) return true;
    if (volume_.make_place(pools_, chunk_coord_ * kChunkEdge, &chunk_) != nullptr) return true;
    chunk_ = nullptr;
    return false;
  }

  /// A node that is free throughout.
  void Free(const VoxelCoord& corner, int edge, const NodePose& from) {
    if (edge > kChunkVoxels) {
      for (int child = 0; child < 8; ++child) Free(ChildCorner(corner, edge / 2, child), edge / 2, from);
      return;
    }
    if (edge == kChunkVoxels) EnterChunk(corner);
    for (int z = 0; z < edge; z += kBlockEdge) {
      for (int y = 0; y < edge; y += kBlockEdge) {
        for (int x = 0; x < edge; x += kBlockEdge) VisitBlock({corner + VoxelCoord(x, y, z), true, true, nullptr, 0, &from});
      }
    }
  }

  /// A block on its way through a scan.
  struct BlockVisit {
    VoxelCoord corner;
    bool is_free;            ///< it is seen through as a whole
    bool has_gaps;           ///< parts of it may be
    const NodeViews* views;  ///< how it looks as one of eight children; null for a part of a larger free node
    int child;
    const NodePose* from;    ///< where it is seen from, without views
  };

  /// Is it far enough away for its voxels to be looked up from its own view, if all of them lie in few pixels? One pose
  /// has to see it as a whole as well.
  bool MayBeFar(const BlockVisit& visit, const NodePose& from) const {
    return visit.views != nullptr && from.share < 1 && visit.views->distance_m[visit.child] > kMinFarVoxels * voxel_m_;
  }

  NodePose PoseFor(const BlockVisit& visit) const {
    return visit.views != nullptr ? PoseFor(*visit.views, visit.child, kBlockEdge) : *visit.from;
  }

  void VisitBlock(const BlockVisit& visit) {
    const int index = index_in_block(parent_coord(visit.corner));
    const std::uint32_t place = chunk_ != nullptr ? chunk_->places[index] : 0;
    ScanMarks::Marked* marked = slots_ != nullptr && slots_[index] != 0 ? &marks_.in_slot(slots_[index]) : nullptr;
    if (marked == nullptr && !Volume::has_block(place) && Volume::coarse_value(place) <= 0) {
      if (visit.is_free) {
        ++result_.blocks_free;
        UpdateNode(index, kAllOctants);
      } else if (visit.has_gaps && Volume::known_octants(place) != kAllOctants && !MayWait(visit)) {
        ++result_.blocks_coarse;
        UpdateNode(index, FreeOctants(visit, Volume::known_octants(place)));
      }
      return;
    }
    if (marked == nullptr && visit.is_free && Volume::has_block(place)) {
      Block& block = pools_.store.block(Volume::block_index(place));
      if (HighestIn(block) <= 0) {
        ++result_.blocks_free;
        AddEvidence(evidence_, kAll, kAll, kNone, block);
        volume_.settle_block(pools_, *chunk_, chunk_->places[index]);
        return;
      }
    }
    if (Volume::has_block(place) && MayWait(visit)) return;
    LookInto(visit, index, marked);
  }

  /// Is the block so far away that beams pass between its voxels? Every other scan is enough for it, half of the blocks in
  /// turn: what it then shows of free space counts twice. Returns are not kept waiting.
  bool IsSparse(const BlockVisit& visit) const {
    return visit.views != nullptr && visit.views->distance_m[visit.child] > sparse_m_;
  }
  bool MayWait(const BlockVisit& visit) const {
    const VoxelCoord& corner = visit.corner;
    return !is_first_ && IsSparse(visit) &&
           (((corner.x() ^ corner.y() ^ corner.z()) >> kBlockShift ^ static_cast<int>(scan_number_)) & 1) != 0;
  }

  /// What the octants of a block that is bare or coarse have shown: those that are seen through as wholes.
  void UpdateNode(int index, OctantMask free) {
    if (free == kNoOctants) return;
    if (!MakeChunk()) {
      result_.voxels_declined += kBlockVoxels;
      return;
    }
    AddFreeOctants(evidence_, free, std::popcount(free) * kOctantVoxels, pools_, volume_, *chunk_,
                   chunk_->places[index]);
  }

  /// Octants that are seen through as wholes, but for a few voxels at their borders.
  OctantMask FreeOctants(const BlockVisit& visit, OctantMask known) const {
    const NodePose from = PoseFor(visit);
    unsigned candidates = kAllOctants;
    if (visit.views != nullptr && from.share < 1 && visit.views->distance_m[visit.child] > kMinLookVoxels * voxel_m_) {
      // Most blocks that come here show nothing: one look at the middles of their octants tells.
      const VoxelLook look(*this, LinearView(*visit.views, visit.child), 0.5f * (kBlockEdge - 1), false);
      candidates = look.At(kOctantMiddles, 0, kWhole).free & kAllOctants;
      if (candidates == kNoOctants) return kNoOctants;
      if (look.fits() && visit.views->distance_m[visit.child] > kMinFarVoxels * voxel_m_) {
        unsigned free = 0;
        for (unsigned open = candidates; open != 0; open &= open - 1) {
          const int octant = std::countr_zero(open);
          free |= static_cast<unsigned>(IsSeenThrough(look, octant)) << octant;
        }
        return static_cast<OctantMask>(free);
      }
    }
    NodeViews views;
    ViewChildren(visit.corner, kOctantEdge, from, views);
    unsigned free = views.free;
    if (from.share < 1) {
      for (unsigned open = views.mixed & views.gaps & candidates & ~unsigned{known}; open != 0; open &= open - 1) {
        const int child = std::countr_zero(open);
        const VoxelLook look(*this, LinearView(views, child), 0.5f * (kOctantEdge - 1), false);
        free |= static_cast<unsigned>(IsSeenThrough(look, kWholeNode)) << child;
      }
    }
    return static_cast<OctantMask>(free);
  }

  /// @param octant  of the block that the look is at, or kWholeNode when it is at the octant itself
  bool IsSeenThrough(const VoxelLook& look, int octant) const {
    int num_unseen = 0;
    for (int z = 0; z < kOctantEdge && num_unseen <= kMaxUnseenVoxels; ++z) {
      const float dz = static_cast<float>(z) - 1.5f;
      const SliceBits bits = octant == kWholeNode ? look.At(kOctantSlice, dz, kWhole)
                                                  : look.At(kOctantSlices[octant & 3], dz + ((octant & 4) != 0 ? 2 : -2), kWhole);
      num_unseen += 16 - std::popcount(bits.free);
    }
    return num_unseen <= kMaxUnseenVoxels;
  }

  /// A block with returns or with voxels of its own: decided voxel by voxel. If it is seen through as a whole, what
  /// remains to be found out is which voxels beams have crossed.
  void LookInto(const BlockVisit& visit, int index, ScanMarks::Marked* marked) {
    ++result_.blocks_mixed;
    BlockBits free = visit.is_free ? kAll : kNone, crossed = kNone;
    const std::uint32_t place = chunk_ != nullptr ? chunk_->places[index] : 0;
    const unsigned occupied = Volume::has_block(place)
                                  ? OccupiedOctants(pools_.store.block(Volume::block_index(place)))
                                  : Volume::coarse_value(place) > 0 ? kAllOctants : kNoOctants;
    const int columns = projection_.num_columns;
    const NodePose from = PoseFor(visit);
    if (MayBeFar(visit, from) && LookUpBlock(LinearView(*visit.views, visit.child), occupied != kNoOctants, free, crossed)) {
      // Done.
    } else if (from.share < 1) {
      LookUpOctants(visit.corner, {from.pose, 0}, kWhole, occupied, free, crossed);
    } else {
      LookUpOctants(visit.corner, {&image_.poses.front(), 0}, {0, columns / 2, true}, occupied, free, crossed);
      LookUpOctants(visit.corner, {&image_.poses.back(), 0}, {columns / 2, columns, true}, occupied, free, crossed);
    }
    const BlockBits& hit = marked != nullptr ? marked->hit : kNone;
    for (int z = 0; z < kBlockEdge; ++z) free.word[z] &= ~hit.word[z];
    if (marked != nullptr) marked->is_applied = true;
    if (marked == nullptr && !free.any()) return;
    if (!MakeChunk()) {
      result_.voxels_declined += kBlockVoxels;
      return;
    }
    result_.voxels_declined +=
        ApplyToPlace(IsSparse(visit) && !is_first_ ? twice_free_ : evidence_, free, crossed, hit, pools_, volume_, *chunk_,
                     chunk_->places[index]);
  }

  /// Looks up a block from its own view. @return false when it has too many pixels for that
  bool LookUpBlock(const LinearView& view, bool has_occupied, BlockBits& free, BlockBits& crossed) const {
    const VoxelLook look(*this, view, 0.5f * (kBlockEdge - 1), has_occupied);
    if (look.fits()) look.AtBlock(free, crossed);
    return look.fits();
  }

  /// Looks up a block octant by octant with one pose, as far as its columns belong to it.
  /// @param occupied  octants with occupied voxels
  void LookUpOctants(const VoxelCoord& corner, const NodePose& from, const ColumnWindow& window, unsigned occupied,
                     BlockBits& free, BlockBits& crossed) const {
    NodeViews views;
    ViewChildren(corner, kOctantEdge, from, views);
    // What is decided for octants is right for one pose only; where two meet, each voxel is asked. Elsewhere, only beams
    // that may see through something, or clear it, are of interest.
    const unsigned seen = window.is_seam ? 0 : views.free;
    const unsigned ask = window.is_seam ? views.free | views.mixed
                                        : (views.mixed & (views.gaps | occupied)) | (views.free & occupied);
    for (int child = 0; child < 8; ++child) {
      const VoxelCoord local = ChildCorner(VoxelCoord::Zero(), kOctantEdge, child);
      const int shift = local.x() + 8 * local.y();
      if ((seen >> child & 1) != 0) {
        for (int z = 0; z < kOctantEdge; ++z) free.word[local.z() + z] |= kOctantRows << shift;
      }
      if ((ask >> child & 1) == 0) continue;
      const VoxelLook look(*this, LinearView(views, child), 0.5f * (kOctantEdge - 1), (occupied >> child & 1) != 0);
      for (int z = 0; z < kOctantEdge; ++z) {
        const SliceBits bits = look.At(kOctantSlice, static_cast<float>(z) - 1.5f, window);
        free.word[local.z() + z] |= Spread(bits.free) << shift;
        crossed.word[local.z() + z] |= Spread(bits.crossed) << shift;
      }
    }
  }

  /// Of sixteen voxels.
  struct SliceBits {
    std::uint32_t free;
    std::uint32_t crossed;
  };

  using Voxels16 = hn::CappedTag<float, 16>;

  /// Pixels around an octant, in registers where they are few: a gather costs as much as all the rest of a look-up.
  class PixelWindow {
   public:
    using D = Voxels16;
    using DI = hn::RebindToSigned<D>;
    static constexpr int kRows = 4, kColumns = 8;

    /// @param reach_*  how far from the view's middle its voxels lie to either side
    PixelWindow(const Carver& carver, const LinearView& view, float column_reach, float sine_reach)
        : stride_(carver.image_.stride), mask_(carver.column_mask_) {
      const auto& rows = carver.projection_.rows;
      const int num_rows = carver.projection_.num_rows();
      column0_ = static_cast<int>(std::floor(view.column - column_reach));
      // The rows above and below all of it; further apart than the window, the search is over.
      const int middle = std::clamp(static_cast<int>(view.row), 0, num_rows - 1);
      int upper = middle, lower = middle;
      while (upper > 0 && upper > middle - kRows && rows[upper].sin_elevation < view.sine + sine_reach) --upper;
      while (lower + 1 < num_rows && lower < upper + kRows && rows[lower].sin_elevation > view.sine - sine_reach) ++lower;
      fits_ = num_rows >= kRows && lower < upper + kRows &&
              static_cast<int>(std::floor(view.column + column_reach + 0.5f)) < column0_ + kColumns;
      row0_ = std::clamp(upper, 0, std::max(num_rows - kRows, 0));
    }

    [[nodiscard]] bool fits() const { return fits_; }
    [[nodiscard]] int row0() const { return row0_; }

    /// Makes ready to look into one image. [rows x stride]
    void Load(const float* pixels) {
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
    HWY_INLINE hn::Vec<D> At(hn::Vec<DI> row, hn::Vec<DI> column) const {
      const D d;
      const DI di;
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
      if (fits_) {
        const auto index = hn::ShiftLeft<3>(row - hn::Set(di, row0_)) + (column - hn::Set(di, column0_));
        const auto lane = hn::IndicesFromVec(d, index & hn::Set(di, static_cast<int>(hn::Lanes(d)) - 1));
        auto value = hn::TableLookupLanes(table_[0], lane);
        for (int i = 1; i < kTables; ++i) {
          const auto is_here = hn::RebindMask(d, index > hn::Set(di, i * static_cast<int>(hn::Lanes(d)) - 1));
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
    VoxelLook(const Carver& carver, const LinearView& view, float reach_voxels, bool has_occupied)
        : carver_(carver),
          view_(view),
          per_distance_(1 / view.distance_m),
          beams_(carver, view, Reach(view.column_step, reach_voxels) + kAngleSlack,
                 Reach(view.sine_step, reach_voxels)),
          gaps_(beams_) {
      // Half a voxel, in columns and by the sine of the elevation.
      const auto width = [](const float (&step)[3]) {
        return 0.5f * std::sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]);
      };
      column_reach_ = width(view.column_step);
      sine_reach_ = width(view.sine_step);
      // Where voxels are wider than the image's cells some beam crosses each of them; elsewhere the gaps tell.
      asks_gaps_ = column_reach_ < 0.5f || sine_reach_ * std::abs(view.rows_per_sine) < 0.5f;
      asks_beams_ = has_occupied || !asks_gaps_;
      // Across many rows, the spacing that they have on the whole.
      const float sine_reach = Reach(view.sine_step, reach_voxels);
      rows_per_sine_ = beams_.fits() ? view.rows_per_sine
                                     : (carver.RowOf(view.sine + sine_reach) - carver.RowOf(view.sine - sine_reach)) /
                                           (2 * sine_reach);
      if (asks_beams_) beams_.Load(carver.image_.free_m.data());
      if (asks_gaps_) gaps_.Load(carver.image_.gap_free_m.data());
    }

    /// How far from the middle the outermost voxels lie.
    static float Reach(const float (&step)[3], float reach_voxels) {
      return kShrinkSlack * reach_voxels * (std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]));
    }

    /// Are all its pixels in registers?
    [[nodiscard]] bool fits() const { return beams_.fits(); }

    /// @param offsets  from the middle, voxels @param dz  added to all of them
    SliceBits At(const Offsets& offsets, float dz, const ColumnWindow& window) const {
      const Voxels16 d;
      using V = hn::Vec<Voxels16>;
      SliceBits bits{0, 0};
      for (int lane = 0; lane < 16; lane += static_cast<int>(hn::Lanes(d))) {
        const V dx = hn::Load(d, offsets.x + lane), dy = hn::Load(d, offsets.y + lane);
        const V z = hn::Load(d, offsets.z + lane) + hn::Set(d, dz);
        const auto along = [&](const float (&step)[3]) HWY_ATTR {
          return hn::Set(d, step[0]) * dx + hn::Set(d, step[1]) * dy + hn::Set(d, step[2]) * z;
        };
        // To second order: what lies further away is seen under a smaller angle, and what lies aside is further away.
        const V away = along(view_.distance_step);
        const V shrunk = hn::Set(d, 1.0f) - away * hn::Set(d, per_distance_);
        const V aside = (dx * dx + dy * dy + z * z) * hn::Set(d, carver_.voxel_m_ * carver_.voxel_m_) - away * away;
        const SliceBits some = Judge(hn::Set(d, view_.column) + along(view_.column_step) * shrunk,
                                     hn::Set(d, view_.sine) + along(view_.sine_step) * shrunk,
                                     hn::Set(d, view_.distance_m) + away + aside * hn::Set(d, 0.5f * per_distance_), window);
        bits.free |= some.free << lane;
        bits.crossed |= some.crossed << lane;
      }
      return bits;
    }

    /// All voxels of a block around the middle, to first order: for one that is far away.
    HWY_INLINE void AtBlock(BlockBits& free, BlockBits& crossed) const {
      const Voxels16 d;
      using V = hn::Vec<Voxels16>;
      for (int pair = 0; pair < 4; ++pair) {
        for (int lane = 0; lane < 16; lane += static_cast<int>(hn::Lanes(d))) {
          const V dx = hn::Load(d, kRowPairs[pair].x + lane), dy = hn::Load(d, kRowPairs[pair].y + lane);
          const auto at = [&](float middle, const float (&step)[3]) HWY_ATTR {
            return hn::Set(d, middle) + hn::Set(d, step[0]) * dx + hn::Set(d, step[1]) * dy;
          };
          const V column = at(view_.column, view_.column_step), sine = at(view_.sine, view_.sine_step);
          const V distance = at(view_.distance_m, view_.distance_step);
          for (int z = 0; z < kBlockEdge; ++z) {
            const float dz = static_cast<float>(z) - 0.5f * (kBlockEdge - 1);
            const SliceBits bits =
                Judge(column + hn::Set(d, view_.column_step[2] * dz), sine + hn::Set(d, view_.sine_step[2] * dz),
                      distance + hn::Set(d, view_.distance_step[2] * dz), kWhole);
            free.word[z] |= std::uint64_t{bits.free} << (16 * pair + lane);
            crossed.word[z] |= std::uint64_t{bits.crossed} << (16 * pair + lane);
          }
        }
      }
    }

   private:
    /// What is known of as many places as a vector has lanes.
    HWY_INLINE SliceBits Judge(hn::Vec<Voxels16> column, hn::Vec<Voxels16> sine, hn::Vec<Voxels16> distance,
                               const ColumnWindow& window) const {
      const Voxels16 d;
      const hn::RebindToSigned<Voxels16> di;
      using V = hn::Vec<Voxels16>;
      const V zero = hn::Zero(d);
      const auto mask = hn::Set(di, carver_.column_mask_);
      const auto before = hn::Set(di, window.first - 1), end = hn::Set(di, window.end);
      const Rows rows = RowsAt(sine);
      const auto is_between = hn::And(sine <= hn::Set(d, carver_.projection_.rows.front().sin_elevation),
                                      sine > hn::Set(d, carver_.projection_.rows.back().sin_elevation));
      unsigned crossed = 0, filled = 0;
      if (asks_beams_) {
        const V beam_column = hn::Round(column);
        const auto is_near = hn::And(hn::Abs(sine - rows.beam_sine) <= hn::Set(d, sine_reach_),
                                     hn::Abs(column - beam_column) <= hn::Set(d, column_reach_));
        const auto column_index = hn::ConvertTo(di, beam_column);
        const V proven = beams_.At(rows.beam, column_index);
        auto is_crossed = hn::And(is_near, proven >= distance);
        if (window.is_seam) {
          // A pixel that was fired at the other end of the scan belongs to the other pose.
          const auto wrapped = column_index & mask;
          const auto is_inside = hn::RebindMask(d, hn::And(wrapped > before, wrapped < end));
          is_crossed = hn::And(hn::And(is_near, hn::Xor(is_inside, proven < zero)), hn::Abs(proven) >= distance);
        }
        crossed = Bits16(d, is_crossed);
      }
      if (asks_gaps_) {
        const auto column_index = hn::ConvertTo(di, hn::Floor(column));
        const V gap = gaps_.At(rows.gap, column_index);
        auto is_filled = hn::And(is_between, gap >= distance);
        if (window.is_seam) {
          const auto wrapped = column_index & mask;
          is_filled = hn::And(is_filled, hn::RebindMask(d, hn::And(wrapped > before, wrapped < end)));
        }
        filled = Bits16(d, is_filled);
      }
      return {crossed | filled, crossed};
    }

    /// Rows of the image by the sine of an elevation: the nearest beam's, and the one above.
    struct Rows {
      hn::Vec<hn::RebindToSigned<Voxels16>> beam, gap;
      hn::Vec<Voxels16> beam_sine;
    };
    HWY_INLINE Rows RowsAt(hn::Vec<Voxels16> sine) const {
      const Voxels16 d;
      const hn::RebindToSigned<Voxels16> di;
      const auto& rows = carver_.projection_.rows;
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
          found.gap = found.gap + hn::IfThenElse(hn::RebindMask(di, sine <= hn::Set(d, lower)), one, zero);
        }
        return found;
      }
      const auto row = hn::Set(d, view_.row) + (sine - hn::Set(d, view_.sine)) * hn::Set(d, rows_per_sine_);
      const auto last_row = hn::Set(d, carver_.last_row_);
      const auto beam = hn::Min(hn::Max(hn::Round(row), hn::Zero(d)), last_row);
      found.beam = hn::ConvertTo(di, beam);
      found.gap = hn::ConvertTo(di, hn::Min(hn::Max(hn::Floor(row), hn::Zero(d)), last_row));
      found.beam_sine = sine + (beam - row) * hn::Set(d, 1 / rows_per_sine_);
      return found;
    }

    const Carver& carver_;
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

  template <class D, class M>
  static HWY_INLINE unsigned Bits16(D d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return bytes[0] | (unsigned{bytes[1]} << 8);
  }

  /// Four rows of four bits, as rows of eight.
  static std::uint64_t Spread(std::uint64_t bits) {
    return (bits & 0xf) | ((bits & 0xf0) << 4) | ((bits & 0xf00) << 8) | ((bits & 0xf000) << 12);
  }

  static constexpr std::uint64_t kOctantRows = 0x0f0f0f0f;  ///< of an octant at 0, in one word of BlockBits
  static constexpr std::uint64_t kFull = ~std::uint64_t{0};
  static constexpr BlockBits kAll{{kFull, kFull, kFull, kFull, kFull, kFull, kFull, kFull, 0}};
  static constexpr BlockBits kNone{};

  const RangeImage& image_;
  const SphericalProjection& projection_;
  const Evidence& evidence_;
  Evidence twice_free_;       ///< the same, but for space seen through in place of two scans
  std::uint64_t scan_number_;
  bool is_first_ = false;     ///< nothing is known of the volume yet
  float sparse_m_ = 0;        ///< from here on rows are more than a voxel apart
  ScanMarks& marks_;
  VoxelPools& pools_;
  Volume& volume_;
  float voxel_m_;
  float max_range_m_;
  float last_row_;
  float columns_per_rad_;  ///< without its sign
  int column_mask_;
  bool has_seam_ = false;

  ChunkCoord chunk_coord_ = ChunkCoord::Zero();
  Chunk* chunk_ = nullptr;
  const ScanMarks::Slot* slots_ = nullptr;
  ProjectiveResult result_;
};

ProjectiveResult IntegrateProjective(const ProjectiveJob& job) { return Carver(job).Run(); }

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cloister {

HWY_EXPORT(IntegrateProjective);

ProjectiveResult integrate_projective(const ProjectiveJob& job) {
  return HWY_DYNAMIC_DISPATCH(IntegrateProjective)(job);
}

}  // namespace cloister
#endif
