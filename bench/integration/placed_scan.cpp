#include "bench/integration/placed_scan.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "mapping/scan/scan_motion.hpp"

namespace cloister {
namespace {

// A surface this level counts as ground when it is this far below the sensor.
constexpr float kLevelCosine = 0.966f;  // 15 degrees
constexpr float kBelowSensorM = 0.3f;
// Neighbours in a row are taken this many columns apart, so that the ranges' noise does not tilt the plane.
constexpr int kColumnsApart = 4;
// The point must lie this close to the line between them.
constexpr float kMaxBendM = 0.03f;

/// Looks at the returns around a pixel. Points are in L: over so few columns the sensor hardly moves.
class Neighbourhood {
 public:
  explicit Neighbourhood(const Scan& scan) : scan_(scan), geometry_(*scan.geometry) {}

  /// Normal of the plane through the neighbours in the row and the nearer one in the column, when they are there and
  /// the row is straight.
  [[nodiscard]] std::optional<Eigen::Vector3f> normal_L(int beam, int column) const {
    const auto point = point_L(beam, column);
    const auto left = point_L(beam, column - kColumnsApart);
    const auto right = point_L(beam, column + kColumnsApart);
    if (!point || !left || !right) return std::nullopt;
    const Eigen::Vector3f along = *right - *left;
    const Eigen::Vector3f offset = *point - *left;
    const float share = offset.dot(along) / along.squaredNorm();
    const float bend_m = (offset - share * along).norm();
    const bool is_straight = bend_m < kMaxBendM && share > 0.2f && share < 0.8f;
    if (!is_straight) return std::nullopt;
    const auto above = point_L(beam - 1, column_of(beam, column, beam - 1));
    const auto below = point_L(beam + 1, column_of(beam, column, beam + 1));
    if (!above && !below) return std::nullopt;
    const auto distance = [&](const auto& p) { return p ? (*p - *point).norm() : 1e9f; };
    const Eigen::Vector3f across = (distance(above) < distance(below) ? *above : *below) - *point;
    const Eigen::Vector3f normal = along.cross(across);
    const float length = normal.norm();
    if (!(length > 1e-9f)) return std::nullopt;
    return normal / length;
  }

 private:
  /// The column of another row that looks the same way.
  [[nodiscard]] int column_of(int beam, int column, int other) const {
    if (other < 0 || other >= geometry_.num_beams) return column;
    const auto& shift = geometry_.pixel_shift;
    return column + shift[static_cast<std::size_t>(beam)] - shift[static_cast<std::size_t>(other)];
  }
  [[nodiscard]] std::optional<Eigen::Vector3f> point_L(int beam, int column) const {
    if (beam < 0 || beam >= geometry_.num_beams) return std::nullopt;
    const int columns = geometry_.num_columns;
    const int wrapped = ((column % columns) + columns) % columns;
    const auto pixel = static_cast<std::size_t>(beam) * columns + wrapped;
    const std::uint32_t range_mm = scan_.ranges_mm[pixel];
    if (range_mm == 0 || !scan_.column_valid[static_cast<std::size_t>(wrapped)])
      return std::nullopt;
    return geometry_.origin_L[pixel] +
           1e-3f * static_cast<float>(range_mm) * geometry_.direction_L[pixel];
  }

  const Scan& scan_;
  const ScanGeometry& geometry_;
};

bool is_within(float range_m, const VoxelConfig& config) {
  return range_m > 0 && range_m >= static_cast<float>(config.min_range_m) &&
         range_m <= static_cast<float>(config.max_range_m);
}

std::vector<Beam> place_columns(const PlacedScan& placed, const VoxelConfig& config, int stride) {
  const Scan& scan = placed.scan;
  const ScanGeometry& geometry = *scan.geometry;
  const Neighbourhood neighbourhood(scan);
  std::vector<Beam> beams;
  for (int column = 0; column < geometry.num_columns; ++column) {
    if (!scan.column_valid[static_cast<std::size_t>(column)]) continue;
    const Eigen::Isometry3f T_S_L =
        sensor_pose(placed, scan.column_stamps[static_cast<std::size_t>(column)]).cast<float>();
    for (int beam = 0; beam < geometry.num_beams; ++beam) {
      const auto pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      const float range_m = 1e-3f * static_cast<float>(scan.ranges_mm[pixel]);
      if (pixel % static_cast<std::size_t>(stride) != 0 || !is_within(range_m, config)) continue;
      const Eigen::Vector3f origin_S = T_S_L * geometry.origin_L[pixel];
      const Eigen::Vector3f end_S =
          origin_S + range_m * (T_S_L.linear() * geometry.direction_L[pixel]);
      const auto normal_L = neighbourhood.normal_L(beam, column);
      const bool is_ground = end_S.z() < origin_S.z() - kBelowSensorM && normal_L &&
                             std::abs((T_S_L.linear() * *normal_L).z()) > kLevelCosine;
      beams.push_back({origin_S, end_S, is_ground});
    }
  }
  return beams;
}

std::vector<Beam> place_cloud(const PlacedScan& placed, const VoxelConfig& config, int stride) {
  const Eigen::Isometry3f T_S_L = sensor_pose(placed, placed.scan.stamp).cast<float>();
  std::vector<Beam> beams;
  for (std::size_t i = 0; i < placed.scan.points_L.size(); i += static_cast<std::size_t>(stride)) {
    const Eigen::Vector3f& point_L = placed.scan.points_L[i];
    if (!is_within(point_L.norm(), config)) continue;
    beams.push_back({T_S_L.translation(), T_S_L * point_L, false});
  }
  return beams;
}

}  // namespace

Pose sensor_pose(const PlacedScan& placed, SensorTime stamp) {
  return placed.T_S_R * ScanMotion(placed.scan.poses).T_R_L(stamp);
}

std::vector<Beam> place_beams(const PlacedScan& placed, const VoxelConfig& config, int stride) {
  return placed.scan.kind == Scan::Kind::kOrganised ? place_columns(placed, config, stride)
                                                    : place_cloud(placed, config, stride);
}

}  // namespace cloister
