#include "bench/simulate/house.hpp"

#include <algorithm>
#include <array>

#include "bench/simulate/building.hpp"
#include "bench/simulate/furniture.hpp"
#include "bench/simulate/path_writer.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/stairs.hpp"

namespace cloister {

namespace {

constexpr double kWest = 0.0;
constexpr double kHallWest = 4.6;
constexpr double kHallEast = 7.6;
constexpr double kEast = 12.2;
constexpr double kSouth = 0.0;
constexpr double kMiddle = 5.0;
constexpr double kBathNorth = 4.0;
constexpr double kNorth = 10.0;
constexpr double kWallHalf = 0.07;

constexpr double kCeiling = 2.6;
constexpr double kUpperFloor = 2.85;
constexpr double kUpperHeight = 2.5;
constexpr double kSlab = 0.25;
constexpr double kSensorHeight = 1.1;

constexpr double kStairsSouth = 2.5;
constexpr double kStairsWest = 6.45;
constexpr Flight kStairs{kStairsWest, kHallEast - kWallHalf, kStairsSouth, 0.0, kUpperFloor};
constexpr double kStairsNorth = kStairs.north_y();
constexpr double kStairsMiddle = 6.98;
constexpr double kHoleWest = 6.40;
constexpr double kHoleSouth = 2.9;

constexpr float kPlaster = 0.7F;
constexpr float kFloorAlbedo = 0.35F;
constexpr float kWood = 0.45F;

/// Centres of the doorways along their walls; the seed moves each a little.
struct Doors {
  double kitchen, kitchen_living, living, workshop, workshop_study, study;
  double bed_a, bed_a_bed_b, bed_b, bath, bath_office, office;
};

Doors place_doors(RandomStream* random) {
  const auto near = [&](double center) { return center + random->uniform(-0.15, 0.15); };
  return {near(1.7), near(2.1), near(7.9), near(8.3), near(9.9), near(1.35),
          near(8.0), near(2.2), near(1.8), near(1.4), near(9.9), near(8.3)};
}

Opening door(double center) { return {center, 0.9, 0.0, 2.0}; }
Opening window(double center, double width = 1.2) { return {center, width, 0.95, 2.1}; }

void add_walls(const Doors& doors, std::vector<BoxSolid>* solids) {
  const auto across_x = [&](double y, double from, double to, double foot, double height,
                            std::vector<Opening> openings) {
    append_wall({true, y, from, to, foot, height, 2 * kWallHalf, std::move(openings)}, kPlaster,
                solids);
  };
  const auto across_y = [&](double x, double foot, double height, std::vector<Opening> openings) {
    append_wall({false, x, kSouth - kWallHalf, kNorth + kWallHalf, foot, height, 2 * kWallHalf,
                 std::move(openings)},
                kPlaster, solids);
  };
  // Most windows are shut and flush with the wall; light leaves through these.
  across_y(kWest, 0.0, kCeiling, {window(7.3)});
  across_y(kHallWest, 0.0, kCeiling, {door(doors.kitchen), door(doors.living)});
  across_y(kHallEast, 0.0, kCeiling, {door(doors.study), door(doors.workshop)});
  across_y(kEast, 0.0, kCeiling, {window(2.4, 1.0)});
  across_x(kSouth, kWest, kEast, 0.0, kCeiling, {});
  across_x(kNorth, kWest, kEast, 0.0, kCeiling, {window(10.2)});
  across_x(kMiddle, kWest, kHallWest, 0.0, kCeiling, {door(doors.kitchen_living)});
  across_x(kMiddle, kHallEast, kEast, 0.0, kCeiling, {door(doors.workshop_study)});

  across_y(kWest, kUpperFloor, kUpperHeight, {window(2.6)});
  across_y(kHallWest, kUpperFloor, kUpperHeight, {door(doors.bed_b), door(doors.bed_a)});
  across_y(kHallEast, kUpperFloor, kUpperHeight, {door(doors.bath), door(doors.office)});
  across_y(kEast, kUpperFloor, kUpperHeight, {window(7.0)});
  across_x(kSouth, kWest, kEast, kUpperFloor, kUpperHeight, {});
  across_x(kNorth, kWest, kEast, kUpperFloor, kUpperHeight, {});
  across_x(kMiddle, kWest, kHallWest, kUpperFloor, kUpperHeight, {door(doors.bed_a_bed_b)});
  across_x(kBathNorth, kHallEast, kEast, kUpperFloor, kUpperHeight, {door(doors.bath_office)});
}

void add_slabs_and_stairs(std::vector<BoxSolid>* solids) {
  const auto slab = [](double z) {
    return BoxSolid::from_corners_m({kWest - kWallHalf, kSouth - kWallHalf, z},
                                    {kEast + kWallHalf, kNorth + kWallHalf, z + kSlab},
                                    kFloorAlbedo);
  };
  solids->push_back(slab(-kSlab));
  const BoxSolid hole = BoxSolid::from_corners_m(
      {kHoleWest, kHoleSouth, kCeiling}, {kHallEast - kWallHalf, kStairsNorth, kUpperFloor}, 0.0F);
  append_slab_with_hole(slab(kCeiling), hole, solids);
  solids->push_back(slab(kUpperFloor + kUpperHeight));
  append_flight(kStairs, kWood, solids);
  append_balustrade(hole, HoleWall::kEast, kUpperFloor, kWood, solids);
}

std::vector<Room> list_rooms() {
  std::vector<Room> rooms;
  const auto add = [&](const char* name, int storey, double x0, double y0, double x1, double y1) {
    const double floor = storey == 0 ? 0.0 : kUpperFloor;
    const double ceiling = storey == 0 ? kCeiling : kUpperFloor + kUpperHeight;
    rooms.push_back({static_cast<int>(rooms.size()),
                     name,
                     storey,
                     {x0 + kWallHalf, y0 + kWallHalf, floor},
                     {x1 - kWallHalf, y1 - kWallHalf, ceiling}});
  };
  add("hall", 0, kHallWest, kSouth, kHallEast, kNorth);
  add("kitchen", 0, kWest, kSouth, kHallWest, kMiddle);
  add("living room", 0, kWest, kMiddle, kHallWest, kNorth);
  add("workshop", 0, kHallEast, kMiddle, kEast, kNorth);
  add("study", 0, kHallEast, kSouth, kEast, kMiddle);
  add("landing", 1, kHallWest, kSouth, kHallEast, kNorth);
  add("bedroom A", 1, kWest, kMiddle, kHallWest, kNorth);
  add("bedroom B", 1, kWest, kSouth, kHallWest, kMiddle);
  add("bath", 1, kHallEast, kSouth, kEast, kBathNorth);
  add("office", 1, kHallEast, kBathNorth, kEast, kNorth);
  return rooms;
}

void walk_ground_floor(const Doors& doors, PathWriter* path) {
  path->set_floor(0.0);
  path->exact(5.75, doors.kitchen - 0.1);
  path->through_wall_at_x(kHallWest, doors.kitchen, -1.0);
  path->around(2.6, 1.5);
  path->around(1.5, 2.4, 0.8);
  path->around(1.7, 3.7);
  path->through_wall_at_y(doors.kitchen_living, kMiddle, 1.0);
  path->around(1.6, 6.9);
  path->around(2.2, 8.1);
  path->around(3.2, 8.2);
  path->through_wall_at_x(kHallWest, doors.living, 1.0);
  path->exact(6.1, 8.1);
  path->through_wall_at_x(kHallEast, doors.workshop, 1.0);
  path->around(9.6, 8.3);
  path->around(10.6, 7.6, 0.8);
  path->around(10.4, 6.5);
  path->through_wall_at_y(doors.workshop_study, kMiddle, -1.0);
  path->around(10.5, 3.2);
  path->around(10.0, 1.9);
  path->around(9.0, 1.5);
  path->through_wall_at_x(kHallEast, doors.study, -1.0);
}

void climb(PathWriter* path) {
  path->set_floor(0.0);
  path->exact(kStairsMiddle - 0.1, kStairsSouth - 0.7);
  path->exact(kStairsMiddle, kStairsSouth);
  path->set_floor(kUpperFloor);
  path->exact(kStairsMiddle, kStairsNorth);
  path->exact(kStairsMiddle - 0.05, kStairsNorth + 0.6);
}

void walk_upper_floor(const Doors& doors, PathWriter* path) {
  path->set_floor(kUpperFloor);
  path->exact(6.2, 7.9);
  path->through_wall_at_x(kHallWest, doors.bed_a, -1.0);
  path->around(2.7, 8.2);
  path->around(1.7, 7.5, 0.8);
  path->around(1.8, 6.5);
  path->through_wall_at_y(doors.bed_a_bed_b, kMiddle, -1.0);
  path->around(1.7, 3.2);
  path->around(2.0, 2.0);
  path->around(3.0, 1.7);
  path->through_wall_at_x(kHallWest, doors.bed_b, 1.0);
  path->exact(6.1, 1.6);
  path->through_wall_at_x(kHallEast, doors.bath, 1.0);
  path->around(9.3, 1.5);
  path->around(10.1, 2.2);
  path->through_wall_at_y(doors.bath_office, kBathNorth, 1.0);
  path->around(10.5, 6.2, 0.8);
  path->around(10.1, 7.6);
  path->around(9.1, 8.2);
  path->through_wall_at_x(kHallEast, doors.office, -1.0);
}

void descend(PathWriter* path) {
  path->set_floor(kUpperFloor);
  path->exact(kStairsMiddle - 0.15, kStairsNorth + 0.7);
  path->exact(kStairsMiddle, kStairsNorth);
  path->set_floor(0.0);
  path->exact(kStairsMiddle, kStairsSouth);
  path->exact(kStairsMiddle - 0.2, kStairsSouth - 0.6);
}

std::vector<Waypoint> walk_two_laps(const Doors& doors, RandomStream* random) {
  PathWriter path(kSensorHeight, random);
  path.exact(6.6, 1.4);
  for (int lap = 0; lap < 2; ++lap) {
    walk_ground_floor(doors, &path);
    climb(&path);
    walk_upper_floor(doors, &path);
    descend(&path);
  }
  path.exact(6.2, 1.4);
  return path.take();
}

std::vector<Piece> pieces_for(const Room& room) {
  using enum Piece;
  if (room.name == "hall" || room.name == "landing") return {kCabinet, kCabinet};
  if (room.name == "kitchen") return {kCounter, kCounter, kWardrobe, kTable, kChair, kChair};
  if (room.name == "living room") return {kSofa, kShelf, kLowTable, kCabinet, kShelf, kChair};
  if (room.name == "workshop") return {kTable, kShelf, kCrate, kCrate, kCrate, kWardrobe, kCrate};
  if (room.name == "study") return {kTable, kShelf, kShelf, kChair, kSofa, kCrate};
  if (room.name == "bath") return {kTub, kCabinet, kCabinet, kCrate};
  if (room.name == "office") return {kTable, kTable, kShelf, kChair, kChair, kCabinet};
  return {kBed, kWardrobe, kCabinet, kChair, kShelf};
}

}  // namespace

World make_house(std::uint64_t seed) {
  constexpr double kClearance = 0.42;
  RandomStream layout = random_stream(seed, Purpose::kWorld);
  RandomStream walk = random_stream(seed, Purpose::kPath);
  World world;
  world.name = "house";
  const Doors doors = place_doors(&layout);
  add_walls(doors, &world.solids);
  add_slabs_and_stairs(&world.solids);
  world.rooms = list_rooms();
  world.path = walk_two_laps(doors, &walk);
  const std::vector<Eigen::Vector3d> path_W = densify(world.path);
  for (const Room& room : world.rooms) {
    // Nothing stands on the stairs, beside them or at their foot and head.
    Room part = room;
    if (room.name == "hall" || room.name == "landing") part.max_W.x() = kStairsWest - 0.1;
    furnish(part, pieces_for(room), path_W, kClearance, &layout, &world.solids);
  }
  world.mesh = union_surface(world.solids);
  return world;
}

}  // namespace cloister
