#include <algorithm>

#include <doctest/doctest.h>

#include "bench/integration/placed_scan.hpp"
#include "bench/integration/room_scan.hpp"

namespace cloister {
namespace {

PlacedScan placed_room() {
  RoomScan room = make_room_scan({8, 6, 2.8});
  // The geometry lives as long as the tests.
  static const std::unique_ptr<ScanGeometry> geometry = std::move(room.geometry);
  room.scan.geometry = geometry.get();
  return {std::move(room.scan), Pose::Identity()};
}

TEST_CASE("beams of a room end on its walls, and those on its floor are ground") {
  const PlacedScan placed = placed_room();
  const std::vector<Beam> beams = place_beams(placed, VoxelConfig{});
  CHECK(beams.size() == placed.scan.ranges_mm.size());
  std::size_t on_floor = 0, ground = 0, ground_elsewhere = 0;
  for (const Beam& beam : beams) {
    CHECK(beam.end_S.z() > -1.202f);
    CHECK(beam.end_S.z() < 1.602f);
    const bool is_floor = beam.end_S.z() < -1.19f;
    on_floor += is_floor;
    ground += beam.is_ground;
    ground_elsewhere += beam.is_ground && !is_floor;
  }
  // Where floor and wall meet, neighbours are on either.
  CHECK(ground > on_floor * 9 / 10);
  CHECK(ground_elsewhere < ground / 50);
}

TEST_CASE("a beam is placed by the pose at its own column") {
  PlacedScan placed = placed_room();
  placed.scan.poses.back().T_R_L.translation().x() = 1;
  placed.T_S_R.translation().y() = 5;
  const std::vector<Beam> beams = place_beams(placed, VoxelConfig{});
  CHECK(beams.front().origin_S.isApprox(Eigen::Vector3f(0, 5, 0), 1e-4f));
  CHECK(beams.back().origin_S.isApprox(Eigen::Vector3f(1, 5, 0), 1e-4f));
  CHECK(beams[beams.size() / 2].origin_S.x() == doctest::Approx(0.5).epsilon(0.01));
}

TEST_CASE("returns out of range and columns never received are left out") {
  PlacedScan placed = placed_room();
  const std::size_t all = place_beams(placed, VoxelConfig{}).size();
  placed.scan.ranges_mm[0] = 0;
  placed.scan.ranges_mm[1] = 100;
  placed.scan.ranges_mm[2] = 70'000;
  placed.scan.column_valid[3] = 0;
  CHECK(place_beams(placed, VoxelConfig{}).size() == all - 3 - 64);
}

}  // namespace
}  // namespace cloister
