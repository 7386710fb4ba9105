#include "firmware_interface/ros2/point_cloud_message.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include "firmware_interface/ouster/ouster_geometry.hpp"
#include "firmware_interface/ros2/cdr_for_tests.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/driver_messages.hpp"

namespace cloister::ros2 {
namespace {

constexpr std::size_t kMaxPoints = 1 << 18;

/// An OS1 of 16 beams: rows look sideways by turns, the ring of emitters is wide, and the sensor frame is turned.
SensorMetadata sensor() {
  SensorMetadata metadata;
  metadata.num_beams = 16;
  metadata.num_columns = 512;
  for (int beam = 0; beam < metadata.num_beams; ++beam) {
    metadata.beam_altitude_rad.push_back((16.6 - 2.2 * beam) * std::numbers::pi / 180);
    const int sideways = 3 - 2 * (beam % 4);
    metadata.beam_azimuth_rad.push_back(sideways * 1.05 * std::numbers::pi / 180);
    metadata.pixel_shift.push_back(static_cast<int>(std::lround(sideways * 1.05 * 512 / 360)));
  }
  metadata.t_lidar_beam_m = {0.0158, 0, 0};
  metadata.T_sensor_lidar = make_pose({0, 0, 0.03618}, Eigen::Quaterniond(0, 0, 0, 1));
  return metadata;
}

/// Distance along a beam to the walls of a room around the sensor.
float distance_to_wall(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
  const Eigen::Vector3f high(4, 3, 1.5f), low(-2.5f, -5, -1);
  float range = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {
    const float wall = direction[axis] > 0 ? high[axis] : low[axis];
    range = std::min(range, (wall - origin[axis]) / direction[axis]);
  }
  return range;
}

/// A revolution in the room. @param is_hidden  pixels (row, fired column) without a return
Scan scan_of_room(
    const ScanGeometry& geometry, SensorTime begin,
    const std::function<bool(int, int)>& is_hidden = [](int, int) { return false; }) {
  Scan scan;
  scan.geometry = &geometry;
  for (int row = 0; row < geometry.num_beams; ++row) {
    for (int column = 0; column < geometry.num_columns; ++column) {
      const std::size_t pixel = static_cast<std::size_t>(row) * geometry.num_columns + column;
      const float range = distance_to_wall(geometry.origin_L[pixel], geometry.direction_L[pixel]);
      scan.ranges_mm.push_back(
          is_hidden(row, column) ? 0 : static_cast<std::uint32_t>(std::lround(1000.0f * range)));
    }
  }
  for (int column = 0; column < geometry.num_columns; ++column) {
    scan.column_stamps.push_back(begin + Duration{195'312L * column});
    scan.column_valid.push_back(1);
  }
  scan.stamp = scan.column_stamps.back();
  return scan;
}

/// The cloud that a driver makes of it: destaggered, misses at zero.
cdr::Cloud cloud_of(const Scan& scan) {
  const ScanGeometry& geometry = *scan.geometry;
  cdr::Cloud cloud;
  const SensorTime begin = scan.column_stamps.front();
  cloud.sec = static_cast<std::int32_t>(begin.ns / 1'000'000'000);
  cloud.nanosec = static_cast<std::uint32_t>(begin.ns % 1'000'000'000);
  cloud.height = static_cast<std::uint32_t>(geometry.num_beams);
  cloud.points.resize(scan.ranges_mm.size());
  for (int row = 0; row < geometry.num_beams; ++row) {
    for (int column = 0; column < geometry.num_columns; ++column) {
      const std::size_t pixel = static_cast<std::size_t>(row) * geometry.num_columns + column;
      const int image_column =
          (column + geometry.pixel_shift[row] + geometry.num_columns) % geometry.num_columns;
      cdr::CloudPoint& point =
          cloud.points[static_cast<std::size_t>(row) * geometry.num_columns + image_column];
      point.ring = static_cast<std::uint16_t>(row);
      point.range = scan.ranges_mm[pixel];
      if (scan.column_valid[column]) {
        point.t = static_cast<std::uint32_t>((scan.column_stamps[column] - begin).ns);
      }
      if (point.range == 0) continue;
      const Eigen::Vector3f p = geometry.origin_L[pixel] + 1e-3f * static_cast<float>(point.range) *
                                                               geometry.direction_L[pixel];
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
    }
  }
  return cloud;
}

bool decode(PointCloudDecoder& decoder, const cdr::Bytes& bytes, MessageCounters& counters,
            Scan& scan) {
  Message<PointCloud2> message;
  REQUIRE(message.decode(bytes, counters));
  return decoder.scan(*message, counters, scan);
}

/// Where a scan's return lies.
Eigen::Vector3f point_of(const Scan& scan, std::size_t pixel) {
  return scan.geometry->origin_L[pixel] +
         1e-3f * static_cast<float>(scan.ranges_mm[pixel]) * scan.geometry->direction_L[pixel];
}

TEST_CASE("an organised cloud becomes the scan it was made of, beam table and all") {
  const ScanGeometry geometry = make_geometry(sensor());
  const Scan truth = scan_of_room(geometry, SensorTime{1'700'000'000'999'000'000},
                                  [](int row, int column) { return (row * 7 + column) % 5 == 0; });
  for (const bool is_big : {false, true}) {
    CAPTURE(is_big);
    cdr::Cloud cloud = cloud_of(truth);
    cloud.ring_is_byte = is_big;
    PointCloudDecoder decoder(kMaxPoints);
    MessageCounters counters;
    Scan scan;
    REQUIRE(decode(decoder, cdr::write_cloud(cloud, is_big), counters, scan));
    CHECK(counters.drops().empty());
    CHECK(counters[MessageCause::kOrganisedCloud] == 1);
    REQUIRE(scan.kind == Scan::Kind::kOrganised);
    REQUIRE(scan.geometry != nullptr);
    CHECK(scan.geometry->projection.has_value());
    CHECK(scan.geometry->pixel_shift == geometry.pixel_shift);
    CHECK(scan.column_stamps == truth.column_stamps);
    CHECK(scan.column_valid == truth.column_valid);
    CHECK(scan.stamp == truth.stamp);
    CHECK(scan.last_packet == truth.stamp);
    CHECK(decoder.frame() == "os_lidar");
    REQUIRE(scan.ranges_mm.size() == truth.ranges_mm.size());
    float worst_m = 0, worst_far_m = 0;
    int num_different = 0;
    for (std::size_t pixel = 0; pixel < truth.ranges_mm.size(); ++pixel) {
      num_different += (scan.ranges_mm[pixel] == 0) != (truth.ranges_mm[pixel] == 0);
      if (truth.ranges_mm[pixel] == 0) continue;
      worst_m = std::max(worst_m, (point_of(scan, pixel) - point_of(truth, pixel)).norm());
      // And where the beam would hit 60 m away, on either side of what was measured.
      const Eigen::Vector3f far = scan.geometry->origin_L[pixel] +
                                  60.0f * scan.geometry->direction_L[pixel] -
                                  geometry.origin_L[pixel];
      worst_far_m = std::max(worst_far_m, far.cross(geometry.direction_L[pixel]).norm());
    }
    CHECK(num_different == 0);
    CHECK(worst_m < 0.001f);
    CHECK(worst_far_m < 0.003f);
  }
}

TEST_CASE("what scan_message publishes comes back as the same scan") {
  const ScanGeometry geometry = make_geometry(sensor());
  const Scan truth = scan_of_room(geometry, SensorTime{5'000'000'000});
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, scan_message(truth, "os_sensor").encode(), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  CHECK(scan.column_stamps == truth.column_stamps);
  CHECK(decoder.frame() == "os_sensor");
  for (std::size_t pixel = 0; pixel < truth.ranges_mm.size(); pixel += 37) {
    CHECK((point_of(scan, pixel) - point_of(truth, pixel)).norm() < 0.001f);
  }

  Scan cloud;
  cloud.kind = Scan::Kind::kCloud;
  cloud.stamp = SensorTime{77};
  cloud.points_L = {{1, 2, 3}, {-4, 5, -6}};
  PointCloudDecoder other(kMaxPoints);
  REQUIRE(decode(other, scan_message(cloud, "os_sensor").encode(), counters, scan));
  CHECK(scan.kind == Scan::Kind::kCloud);
  CHECK(scan.stamp.ns == 77);
  CHECK(scan.points_L == cloud.points_L);
}

TEST_CASE("columns that never arrived are not valid, and do not move the others") {
  const ScanGeometry geometry = make_geometry(sensor());
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(scan_of_room(geometry, SensorTime{0})), false),
                 counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);

  Scan truth = scan_of_room(geometry, SensorTime{100'000'000},
                            [](int, int column) { return column >= 16 && column < 48; });
  for (int column = 16; column < 48; ++column) truth.column_valid[column] = 0;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(truth), false), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  CHECK(scan.column_valid == truth.column_valid);
  CHECK(scan.column_stamps[15] == truth.column_stamps[15]);
  CHECK(scan.column_stamps[48] == truth.column_stamps[48]);
  CHECK(counters[MessageCause::kBeamTable] == 1);
}

TEST_CASE(
    "a first cloud with lost columns is taken as points, since the first column cannot be told") {
  const ScanGeometry geometry = make_geometry(sensor());
  Scan truth =
      scan_of_room(geometry, SensorTime{100'000'000}, [](int, int column) { return column < 16; });
  for (int column = 0; column < 16; ++column) truth.column_valid[column] = 0;
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(truth), false), counters, scan));
  CHECK(scan.kind == Scan::Kind::kCloud);
  CHECK(scan.points_L.size() == 16 * (512 - 16));
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(scan_of_room(geometry, SensorTime{0})), false),
                 counters, scan));
  CHECK(scan.kind == Scan::Kind::kOrganised);
}

TEST_CASE("rows that have seen nothing are filled in, and made anew once they have") {
  const ScanGeometry geometry = make_geometry(sensor());
  const Scan sky =
      scan_of_room(geometry, SensorTime{0}, [](int row, int) { return row < 5 || row == 9; });
  // A few returns do not make a row known.
  const Scan bird = scan_of_room(
      geometry, SensorTime{0}, [](int row, int column) { return row == 2 ? column > 2 : row < 5; });
  const Scan room = scan_of_room(geometry, SensorTime{0});
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(sky), false), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  const ScanGeometry* first_table = scan.geometry;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(bird), false), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  CHECK(counters[MessageCause::kReturnOfUnknownBeam] > 0);
  REQUIRE(decode(decoder, cdr::write_cloud(cloud_of(room), false), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  CHECK(scan.geometry != first_table);
  CHECK(first_table->num_beams == 16);  // scans under way may still use it
  CHECK(std::ranges::count(scan.ranges_mm, 0u) == 0);
  CHECK(counters[MessageCause::kBeamTable] == 2);
}

TEST_CASE("a cloud that was deskewed is taken as points, before and after a beam table is known") {
  const ScanGeometry geometry = make_geometry(sensor());
  const Scan room = scan_of_room(geometry, SensorTime{0});
  cdr::Cloud deskewed = cloud_of(room);
  for (cdr::CloudPoint& point : deskewed.points) {
    const float share = static_cast<float>(point.t) * 1e-8f;
    const Eigen::Vector3f p = Eigen::AngleAxisf(0.1f * share, Eigen::Vector3f::UnitZ()) *
                                  Eigen::Vector3f(point.x, point.y, point.z) +
                              Eigen::Vector3f(0.1f, 0, 0.05f) * share;
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
  }
  const cdr::Bytes bytes = cdr::write_cloud(deskewed, false);
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, bytes, counters, scan));
  CHECK(scan.kind == Scan::Kind::kCloud);

  PointCloudDecoder learned(kMaxPoints);
  REQUIRE(decode(learned, cdr::write_cloud(cloud_of(room), false), counters, scan));
  REQUIRE(scan.kind == Scan::Kind::kOrganised);
  REQUIRE(decode(learned, bytes, counters, scan));
  CHECK(scan.kind == Scan::Kind::kCloud);
  CHECK(scan.points_L.size() == room.ranges_mm.size());
  CHECK(counters[MessageCause::kBeamTableMismatch] == 1);
}

TEST_CASE(
    "clouds without times, of one row, with rows that are no beams, or asked for as such are "
    "points") {
  const ScanGeometry geometry = make_geometry(sensor());
  const cdr::Cloud room = cloud_of(scan_of_room(geometry, SensorTime{0}));
  cdr::Cloud timeless = room, flat = room, shuffled = room;
  timeless.has_t = false;
  flat.height = 1;
  std::swap(shuffled.points[100].ring, shuffled.points[700].ring);
  for (const cdr::Cloud& cloud : {timeless, flat, shuffled}) {
    PointCloudDecoder decoder(kMaxPoints);
    MessageCounters counters;
    Scan scan;
    REQUIRE(decode(decoder, cdr::write_cloud(cloud, false), counters, scan));
    CHECK(scan.kind == Scan::Kind::kCloud);
    CHECK(scan.points_L.size() == room.points.size());
    CHECK(counters[MessageCause::kUnorganisedCloud] == 1);
  }
  PointCloudDecoder decoder(kMaxPoints, true);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, cdr::write_cloud(room, false), counters, scan));
  CHECK(scan.kind == Scan::Kind::kCloud);
}

TEST_CASE("points at zero, at no number, or without a range are misses") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  cdr::Cloud cloud;
  cloud.points = {
      {0, 0, 0, 0, 0, 1}, {kNan, kNan, kNan, 0, 0, 1}, {1, 2, 3, 0, 0, 0}, {1, 2, 3, 0, 0, 3742}};
  PointCloudDecoder decoder(kMaxPoints);
  MessageCounters counters;
  Scan scan;
  REQUIRE(decode(decoder, cdr::write_cloud(cloud, true), counters, scan));
  REQUIRE(scan.points_L.size() == 1);
  CHECK(scan.points_L[0] == Eigen::Vector3f(1, 2, 3));
}

TEST_CASE("clouds whose sizes or fields do not hold together are counted and dropped") {
  cdr::Cloud cloud;
  cloud.points.resize(64);
  cloud.height = 4;
  Message<PointCloud2> message;
  MessageCounters counters;
  PointCloudDecoder decoder(1000);
  Scan scan;
  const auto dropped_as = [&](MessageCause cause, auto&& spoil) {
    REQUIRE(message.decode(cdr::write_cloud(cloud, false), counters));
    REQUIRE(decoder.scan(*message, counters, scan));
    spoil(*message);
    const auto before = counters[cause];
    CHECK_FALSE(decoder.scan(*message, counters, scan));
    CHECK(counters[cause] == before + 1);
  };
  using Cause = MessageCause;
  dropped_as(Cause::kBadCloudLayout, [](PointCloud2& m) { m.width = 17; });
  dropped_as(Cause::kBadCloudLayout, [](PointCloud2& m) { m.row_step -= 1; });
  dropped_as(Cause::kBadCloudLayout, [](PointCloud2& m) { m.row_step += 1; });
  dropped_as(Cause::kBadCloudLayout, [](PointCloud2& m) { m.point_step = 0xffffffff; });
  dropped_as(Cause::kBadCloudLayout, [](PointCloud2& m) { m.data._length -= 1; });
  dropped_as(Cause::kCloudTooLarge, [](PointCloud2& m) { m.width = 0xffffffff; });
  dropped_as(Cause::kCloudTooLarge, [](PointCloud2& m) { m.width = 251; });
  dropped_as(Cause::kEmptyCloud, [](PointCloud2& m) { m.height = 0; });
  dropped_as(Cause::kMissingCloudFields, [](PointCloud2& m) { m.fields._buffer[2].name[0] = 'w'; });
  dropped_as(Cause::kMissingCloudFields, [](PointCloud2& m) { m.fields._buffer[1].datatype = 5; });
  dropped_as(Cause::kMissingCloudFields, [](PointCloud2& m) { m.fields._buffer[0].offset = 45; });
  dropped_as(Cause::kMissingCloudFields,
             [](PointCloud2& m) { m.fields._buffer[0].offset = 0xfffffffe; });
  dropped_as(Cause::kMissingCloudFields, [](PointCloud2& m) { m.point_step = 0; });
  dropped_as(Cause::kBadStamp, [](PointCloud2& m) { m.header.stamp.nanosec = 1'000'000'000; });
  dropped_as(Cause::kChangedFrame, [](PointCloud2& m) { m.header.frame_id[0] = 'X'; });
}

}  // namespace
}  // namespace cloister::ros2
