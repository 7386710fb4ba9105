#include "bench/integration/room_scan.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "mapping/scan/spherical_projection.hpp"

namespace cloister {
namespace {

constexpr int kBeams = 64;
constexpr int kColumns = 1024;
constexpr double kHalfViewRad = std::numbers::pi / 4;
constexpr double kRoomYawRad = 0.3;
constexpr double kSensorHeightM = 1.2;
constexpr std::int64_t kScanNs = 100'000'000;

/// Way from the sensor to the walls in a direction, both in the room's own axes.
double range_to_box_m(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                      const Eigen::Vector3d& direction) {
  double range_m = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (std::abs(direction[k]) < 1e-12) continue;
    range_m = std::min(range_m, (direction[k] > 0 ? high[k] : low[k]) / direction[k]);
  }
  return range_m;
}

}  // namespace

RoomScan make_room_scan(const Eigen::Vector3d& size_m) {
  const Eigen::Vector3d low(-size_m.x() / 2, -size_m.y() / 2, -kSensorHeightM);
  const Eigen::Vector3d high = low + size_m;
  const Eigen::Matrix3d R_room_L =
      Eigen::AngleAxisd(-kRoomYawRad, Eigen::Vector3d::UnitZ()).toRotationMatrix();

  RoomScan room{std::make_unique<ScanGeometry>(), {}};
  ScanGeometry& geometry = *room.geometry;
  Scan& scan = room.scan;
  geometry.num_beams = kBeams;
  geometry.num_columns = kColumns;
  geometry.pixel_shift.assign(kBeams, 0);
  scan.geometry = room.geometry.get();
  for (int beam = 0; beam < kBeams; ++beam) {
    const double elevation_rad = kHalfViewRad * (1 - 2.0 * beam / (kBeams - 1));
    for (int column = 0; column < kColumns; ++column) {
      // Clockwise seen from above, as the sensor turns.
      const double azimuth_rad = -2 * std::numbers::pi * column / kColumns;
      const Eigen::Vector3d direction(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                      std::cos(elevation_rad) * std::sin(azimuth_rad),
                                      std::sin(elevation_rad));
      geometry.direction_L.push_back(direction.cast<float>());
      geometry.origin_L.push_back(Eigen::Vector3f::Zero());
      const double range_m = range_to_box_m(low, high, R_room_L * direction);
      scan.ranges_mm.push_back(static_cast<std::uint32_t>(std::lround(1e3 * range_m)));
    }
  }
  geometry.projection = fit_projection(kBeams, kColumns, geometry.direction_L, geometry.origin_L);
  scan.column_valid.assign(kColumns, 1);
  for (int column = 0; column < kColumns; ++column) {
    scan.column_stamps.push_back({kScanNs * column / kColumns});
  }
  scan.stamp = scan.last_packet = scan.column_stamps.back();
  scan.poses = {{scan.column_stamps.front(), Pose::Identity()}, {scan.stamp, Pose::Identity()}};
  return room;
}

}  // namespace cloister
