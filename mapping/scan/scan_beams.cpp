#include "mapping/scan/scan_beams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mapping/scan/image_row.hpp"
#include "mapping/scan/scan_motion.hpp"

namespace cloister {
namespace {

constexpr float kMetresPerMillimetre = 1e-3f;
// Vector stores run past the last return.
constexpr std::size_t kStorePadding = 64;
constexpr int kPoseEntries = 12;
// In front of each row of ranges: repeats its last column, and keeps rows aligned.
constexpr int kRowFront = 1;
// Less motion than this during a scan is none.
constexpr float kStillRad = 1e-3f;
constexpr float kStillM = 5e-3f;

}  // namespace

ScanBeams::ScanBeams(std::size_t max_points) : max_points_(max_points) {
  image_.reserve(max_points);
  rays_.reserve(max_points);
  for (std::vector<float>* returns : {&x_S_, &y_S_, &z_S_})
    returns->resize(max_points + kStorePadding);
  range_m_.reserve(max_points + max_points / 2);
  column_pose_.reserve(kPoseEntries * 2 * max_points);
  column_bits_.reserve(max_points);
}

void ScanBeams::place_columns(const Scan& scan, const Pose& T_S_R) {
  const int columns = scan.geometry->num_columns;
  const std::size_t stride = 2 * static_cast<std::size_t>(columns);
  column_pose_.resize(kPoseEntries * stride);
  image_.poses.resize(static_cast<std::size_t>(columns));
  column_bits_.resize(static_cast<std::size_t>(columns));
  ScanMotion motion(scan.poses);
  Pose T_S_L = T_S_R * scan.poses.front().T_R_L;
  Pose T_S_first = T_S_L;
  bool is_first = true;
  double least_cosine = 1;
  image_.moved_m = 0;
  for (int column = 0; column < columns; ++column) {
    column_bits_[column] = scan.column_valid[column] ? ~std::uint32_t{0} : 0;
    // A lost column was where the one before it was.
    if (scan.column_valid[column]) {
      T_S_L = T_S_R * motion.T_R_L(scan.column_stamps[column]);
      if (is_first) T_S_first = T_S_L;
      is_first = false;
      const double trace =
          T_S_first.linear().cwiseProduct(T_S_L.linear()).sum();  // of one rotation after the other
      least_cosine = std::min(least_cosine, 0.5 * (trace - 1));
      image_.moved_m =
          std::max(image_.moved_m,
                   static_cast<float>((T_S_L.translation() - T_S_first.translation()).norm()));
    }
    RangeImage::ColumnPose& pose = image_.poses[column];
    pose.t_S = T_S_L.translation().cast<float>();
    for (int row = 0; row < 3; ++row) {
      for (int i = 0; i < 3; ++i) pose.R_L_S[row][i] = static_cast<float>(T_S_L.linear()(i, row));
    }
    for (int i = 0; i < kPoseEntries; ++i) {
      const double entry = i < 9 ? T_S_L.linear()(i / 3, i % 3) : T_S_L.translation()[i - 9];
      column_pose_[i * stride + column] = column_pose_[i * stride + columns + column] =
          static_cast<float>(entry);
    }
  }
  image_.turned_rad = static_cast<float>(std::acos(std::max(least_cosine, -1.0)));
}

void ScanBeams::assign_image(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  const SphericalProjection& projection = *scan.geometry->projection;
  const int columns = projection.num_columns;
  const int rows = projection.num_rows();
  place_columns(scan, T_S_R);
  const bool is_still = image_.turned_rad < kStillRad && image_.moved_m < kStillM;

  const std::size_t stride = static_cast<std::size_t>(columns) + RangeImage::kPadding;
  image_.projection = &projection;
  image_.stride = static_cast<int>(stride);
  range_m_.resize(stride * rows + RangeImage::kPadding);
  image_.free_m.resize(stride * rows);
  const float nearest_m =
      std::max(static_cast<float>(config.min_range_m), std::numeric_limits<float>::min());
  const float depth_m = static_cast<float>(config.return_depth_m);
  for (int row = 0; row < rows; ++row) {
    const auto& beam = projection.rows[row];
    float* range = &range_m_[row * stride + kRowFront];
    const std::uint32_t* raw = &scan.ranges_mm[static_cast<std::size_t>(row) * columns];
    const float add_m = depth_m - beam.range_offset_m;
    // Column c of the scan is column c - shift of the image, around the turn.
    const auto copy = [&](int from, int to, int offset) {
      for (int column = from; column < to; ++column) {
        // Signed, as that is the conversion that vectors have: no range comes near 2^31.
        const auto millimetres =
            static_cast<std::int32_t>(raw[column + offset] & column_bits_[column + offset]);
        const float measured_m = kMetresPerMillimetre * static_cast<float>(millimetres);
        range[column] = measured_m >= nearest_m ? measured_m + add_m : 0;
      }
    };
    copy(0, columns - beam.shift, beam.shift);
    copy(columns - beam.shift, columns, beam.shift - columns);
    range[-1] = range[columns - 1];
    for (int i = 0; i + kRowFront < RangeImage::kPadding; ++i) range[columns + i] = range[i];
  }
  for (int row = 0; row < rows; ++row) {
    const auto& beam = projection.rows[row];
    ImageRow line;
    line.projection = &projection;
    line.row = row;
    line.num_columns = columns;
    line.range_m = &range_m_[row * stride + kRowFront];
    line.above_m = row > 0 ? line.range_m - stride : nullptr;
    line.below_m = row + 1 < rows ? line.range_m + stride : nullptr;
    line.angle_above_rad =
        row > 0 ? projection.rows[row - 1].elevation_rad - beam.elevation_rad : 0;
    line.angle_below_rad =
        row + 1 < rows ? beam.elevation_rad - projection.rows[row + 1].elevation_rad : 0;
    line.column_pose = column_pose_.data() + beam.shift;
    line.pose_stride = 2 * static_cast<std::size_t>(columns);
    line.voxel_m = static_cast<float>(config.voxel_size_m);
    line.max_free_m = static_cast<float>(config.max_range_m);
    line.max_return_m = static_cast<float>(config.max_range_m) + depth_m - beam.range_offset_m;
    line.free_m = &image_.free_m[row * stride];
    line.x_S = x_S_.data() + num_returns_;
    line.y_S = y_S_.data() + num_returns_;
    line.z_S = z_S_.data() + num_returns_;
    num_returns_ += place_row(line);
    if (!is_still) {
      // Where the shift wraps around, the pixel was fired at the other end of the scan.
      const bool wraps_behind = beam.shift <= columns / 2;
      const int from = wraps_behind ? columns - beam.shift : 0;
      const int to = wraps_behind ? columns : columns - beam.shift;
      for (int column = from; column < to; ++column) line.free_m[column] = -line.free_m[column];
    }
    for (int i = 0; i < RangeImage::kPadding; ++i) line.free_m[columns + i] = line.free_m[i];
  }
  image_.build_bounds(static_cast<float>(config.max_range_m));
}

void ScanBeams::add_ray(const Eigen::Vector3f& origin_S, const Eigen::Vector3f& direction_S,
                        float range_m, const VoxelConfig& config) {
  if (rays_.size() == max_points_) {
    ++num_declined_;
    return;
  }
  const float max_range_m = static_cast<float>(config.max_range_m);
  const float surface_m = range_m + static_cast<float>(config.return_depth_m);
  const bool is_return = range_m <= max_range_m;
  const float length_m = is_return ? surface_m : max_range_m;
  const float free_m =
      std::clamp(surface_m - static_cast<float>(config.voxel_size_m), 0.5f * length_m, length_m);
  const Eigen::Vector3f end_S = origin_S + length_m * direction_S;
  rays_.push_back({origin_S, end_S, free_m});
  if (!is_return) return;
  x_S_[num_returns_] = end_S.x();
  y_S_[num_returns_] = end_S.y();
  z_S_[num_returns_] = end_S.z();
  ++num_returns_;
}

void ScanBeams::assign_beams(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  const ScanGeometry& geometry = *scan.geometry;
  ScanMotion motion(scan.poses);
  for (int column = 0; column < geometry.num_columns; ++column) {
    if (!scan.column_valid[column]) continue;
    const Pose T_S_L = T_S_R * motion.T_R_L(scan.column_stamps[column]);
    const Eigen::Matrix3f R_S_L = T_S_L.linear().cast<float>();
    const Eigen::Vector3f t_S_L = T_S_L.translation().cast<float>();
    for (int beam = 0; beam < geometry.num_beams; ++beam) {
      const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      const float range_m = kMetresPerMillimetre * static_cast<float>(scan.ranges_mm[pixel]);
      if (range_m == 0 || range_m < config.min_range_m) continue;
      add_ray(R_S_L * geometry.origin_L[pixel] + t_S_L, R_S_L * geometry.direction_L[pixel],
              range_m, config);
    }
  }
}

void ScanBeams::assign_cloud(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  const Pose T_S_L = T_S_R * ScanMotion(scan.poses).T_R_L(scan.stamp);
  const Eigen::Matrix3f R_S_L = T_S_L.linear().cast<float>();
  const Eigen::Vector3f t_S_L = T_S_L.translation().cast<float>();
  for (const Eigen::Vector3f& point_L : scan.points_L) {
    const float range_m = point_L.norm();
    // A point at the origin has no direction, and some drivers write one for each beam that did not return.
    if (!(range_m > 0) || range_m < static_cast<float>(config.min_range_m) ||
        !std::isfinite(range_m))
      continue;
    add_ray(t_S_L, R_S_L * (point_L / range_m), range_m, config);
  }
}

std::size_t ScanBeams::assign(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  rays_.clear();
  image_.projection = nullptr;
  num_returns_ = 0;
  num_declined_ = 0;
  if (scan.kind == Scan::Kind::kCloud) {
    assign_cloud(scan, T_S_R, config);
  } else if (scan.geometry->projection && scan.ranges_mm.size() <= max_points_) {
    assign_image(scan, T_S_R, config);
  } else {
    assign_beams(scan, T_S_R, config);
  }
  return num_declined_;
}

}  // namespace cloister
