#include "mapping/scan/deskew.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloister {
namespace {

constexpr float kMetresPerMillimetre = 1e-3f;
// Beams of every so many columns begin at the sensor; a power of two.
constexpr int kCoarsestColumns = 8;

/// Range at a pixel of a neighbouring row or column, or 0. Columns wrap around a full turn.
float range_at(const Scan& scan, int beam, int column) {
  const int columns = scan.geometry->num_columns;
  if (beam < 0 || beam >= scan.geometry->num_beams) return 0;
  const int wrapped = ((column % columns) + columns) % columns;
  return kMetresPerMillimetre * static_cast<float>(scan.ranges_mm[static_cast<std::size_t>(beam) * columns + wrapped]);
}

/// A return as a point in the sensor frame, ignoring motion: good enough for the slope of a surface.
Eigen::Vector3f point_at(const Scan& scan, int beam, int column, float range_m) {
  const int columns = scan.geometry->num_columns;
  const std::size_t pixel = static_cast<std::size_t>(beam) * columns + ((column % columns) + columns) % columns;
  return scan.geometry->origin_L[pixel] + range_m * scan.geometry->direction_L[pixel];
}

/// Sine of the angle between a beam and the surface it hits, from the nearer of both neighbours in its row and of
/// both in its column. 1 when a neighbour is missing on an axis.
float sine_of_grazing_angle(const Scan& scan, int beam, int column, float range_m) {
  const auto nearer_neighbour = [&](int beam_a, int column_a, int beam_b, int column_b, Eigen::Vector3f& point) {
    const float a = range_at(scan, beam_a, column_a);
    const float b = range_at(scan, beam_b, column_b);
    if (a == 0 && b == 0) return false;
    const bool use_a = b == 0 || (a != 0 && std::abs(a - range_m) <= std::abs(b - range_m));
    point = use_a ? point_at(scan, beam_a, column_a, a) : point_at(scan, beam_b, column_b, b);
    return true;
  };
  const auto& shift = scan.geometry->pixel_shift;
  const int above = beam > 0 ? column + shift[beam] - shift[beam - 1] : column;
  const int below = beam + 1 < scan.geometry->num_beams ? column + shift[beam] - shift[beam + 1] : column;
  Eigen::Vector3f beside, vertical;
  if (!nearer_neighbour(beam, column - 1, beam, column + 1, beside) ||
      !nearer_neighbour(beam - 1, above, beam + 1, below, vertical)) {
    return 1;
  }
  const Eigen::Vector3f point = point_at(scan, beam, column, range_m);
  const Eigen::Vector3f normal = (beside - point).cross(vertical - point);
  const float length = normal.norm();
  if (length <= 1e-9f) return 1;
  const std::size_t pixel = static_cast<std::size_t>(beam) * scan.geometry->num_columns + column;
  return std::abs(normal.dot(scan.geometry->direction_L[pixel])) / length;
}

/// How far a beam proves space free that ends `stretch_m` before its return, and at max_range.
float free_length_m(float range_m, float stretch_m, const VoxelConfig& config) {
  const float length_m = std::min(range_m, static_cast<float>(config.max_range_m));
  return std::clamp(range_m - stretch_m, 0.5f * length_m, length_m);
}

}  // namespace

Pose pose_at(const std::vector<PoseSample>& poses, SensorTime stamp, std::size_t& hint) {
  if (poses.size() == 1 || stamp <= poses.front().stamp) return poses.front().T_R_L;
  if (stamp >= poses.back().stamp) return poses.back().T_R_L;
  while (hint > 0 && poses[hint].stamp > stamp) --hint;
  while (hint + 2 < poses.size() && poses[hint + 1].stamp <= stamp) ++hint;
  const PoseSample& before = poses[hint];
  const PoseSample& after = poses[hint + 1];
  const double span_ns = static_cast<double>((after.stamp - before.stamp).ns);
  if (span_ns <= 0) return after.T_R_L;
  return interpolate(before.T_R_L, after.T_R_L, static_cast<double>((stamp - before.stamp).ns) / span_ns);
}

void RayBundle::add(const Eigen::Vector3f& origin_S, const Eigen::Vector3f& direction_S, const Beam& beam,
                    const VoxelConfig& config) {
  if (rays_.size() == rays_.capacity()) {
    ++num_declined_;
    return;
  }
  const float max_range_m = static_cast<float>(config.max_range_m);
  const bool is_return = beam.range_m <= max_range_m;
  rays_.push_back({origin_S, origin_S + std::min(beam.range_m, max_range_m) * direction_S, beam.start_m, beam.free_m,
                   is_return});
  num_returns_ += is_return;
}

void RayBundle::measure_free(const Scan& scan, const VoxelConfig& config) {
  const ScanGeometry& geometry = *scan.geometry;
  const std::size_t num_pixels = geometry.direction_L.size();
  free_m_.assign(std::min(num_pixels, free_m_.capacity()), 0.0f);
  for (int beam = 0; beam < geometry.num_beams; ++beam) {
    for (int column = 0; column < geometry.num_columns; ++column) {
      const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      const float range_m = kMetresPerMillimetre * static_cast<float>(scan.ranges_mm[pixel]);
      if (pixel >= free_m_.size() || !scan.column_valid[column] || range_m < config.min_range_m || range_m == 0) continue;
      const float sine = std::max(sine_of_grazing_angle(scan, beam, column, range_m), 1e-3f);
      free_m_[pixel] = free_length_m(range_m, static_cast<float>(config.voxel_size_m) / sine, config);
    }
  }
}

float RayBundle::start_of(const ScanGeometry& geometry, int beam, int column, float voxel_m) const {
  // Columns are filled in as a ruler is divided: every eighth first, then those halfway between, and so on.
  const int half_gap = column & -column & (kCoarsestColumns - 1);
  if (half_gap == 0) return 0;
  const std::size_t row = static_cast<std::size_t>(beam) * geometry.num_columns;
  const std::size_t left = row + static_cast<std::size_t>(column - half_gap);
  const std::size_t right = row + static_cast<std::size_t>((column + half_gap) % geometry.num_columns);
  if (right >= free_m_.size()) return 0;
  const float gap_rad = 2 * static_cast<float>(half_gap) * 2 * std::numbers::pi_v<float> /
                        static_cast<float>(geometry.num_columns);
  return std::min({0.5f * voxel_m / gap_rad, free_m_[left], free_m_[right]});
}

void RayBundle::assign_organised(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  const ScanGeometry& geometry = *scan.geometry;
  measure_free(scan, config);
  std::size_t hint = 0;
  for (int column = 0; column < geometry.num_columns; ++column) {
    if (!scan.column_valid[column]) continue;
    const Pose T_S_L = T_S_R * pose_at(scan.poses, scan.column_stamps[column], hint);
    const Eigen::Matrix3f R_S_L = T_S_L.linear().cast<float>();
    const Eigen::Vector3f t_S_L = T_S_L.translation().cast<float>();
    for (int beam = 0; beam < geometry.num_beams; ++beam) {
      const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      if (pixel >= free_m_.size()) {
        num_declined_ += scan.ranges_mm[pixel] != 0;
        continue;
      }
      if (free_m_[pixel] == 0) continue;
      const Beam measured{kMetresPerMillimetre * static_cast<float>(scan.ranges_mm[pixel]),
                          start_of(geometry, beam, column, static_cast<float>(config.voxel_size_m)), free_m_[pixel]};
      add(R_S_L * geometry.origin_L[pixel] + t_S_L, R_S_L * geometry.direction_L[pixel], measured, config);
    }
  }
}

void RayBundle::assign_cloud(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  std::size_t hint = 0;
  const Pose T_S_L = T_S_R * pose_at(scan.poses, scan.stamp, hint);
  const Eigen::Matrix3f R_S_L = T_S_L.linear().cast<float>();
  const Eigen::Vector3f t_S_L = T_S_L.translation().cast<float>();
  for (const Eigen::Vector3f& point_L : scan.points_L) {
    const float range_m = point_L.norm();
    // A point at the origin has no direction, and some drivers write one for each beam that did not return.
    if (!(range_m > 0) || range_m < static_cast<float>(config.min_range_m) || !std::isfinite(range_m)) continue;
    const Beam measured{range_m, 0, free_length_m(range_m, static_cast<float>(config.voxel_size_m), config)};
    add(t_S_L, R_S_L * (point_L / range_m), measured, config);
  }
}

std::size_t RayBundle::assign(const Scan& scan, const Pose& T_S_R, const VoxelConfig& config) {
  rays_.clear();
  num_returns_ = 0;
  num_declined_ = 0;
  if (scan.kind == Scan::Kind::kOrganised) {
    assign_organised(scan, T_S_R, config);
  } else {
    assign_cloud(scan, T_S_R, config);
  }
  return num_declined_;
}

}  // namespace cloister
