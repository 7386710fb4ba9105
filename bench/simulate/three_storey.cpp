#include "bench/simulate/three_storey.hpp"

#include <algorithm>
#include <array>

#include "bench/simulate/building.hpp"
#include "bench/simulate/floor_plan.hpp"
#include "bench/simulate/stairs.hpp"

namespace cloister {

namespace {

constexpr double kSensorHeight = 1.1;
constexpr double kCeiling = 2.6;
constexpr double kSlab = 0.25;
constexpr double kStorey = kCeiling + kSlab;
constexpr double kEast = 20.0;
constexpr double kCorridorSouth = 5.0;
constexpr double kCorridorNorth = 7.0;
constexpr double kNorth = 13.6;
constexpr double kWellWest = 8.3;
constexpr double kWellEast = 11.7;
constexpr double kWellMiddle = 0.5 * (kWellWest + kWellEast);
constexpr double kWallHalf = 0.07;
constexpr double kFlightWidth = 1.03;
constexpr double kFlightSouth = 8.2;
constexpr double kHoleSouth = kFlightSouth + 0.4;
constexpr double kHoleMargin = 0.05;

constexpr float kPlaster = 0.7F;
constexpr float kFloorAlbedo = 0.35F;
constexpr float kConcrete = 0.45F;

/// One storey: rooms in the order they are visited, between a corridor and a stairwell.
struct Storey {
  FloorPlan plan;
  int corridor = 0;
  int well = 0;
  std::vector<int> tour;  ///< from the corridor through all rooms and back to the corridor
};

Storey draw_storey(int number, bool has_windows, RandomStream* random) {
  Storey storey{FloorPlan(number, number * kStorey, kCeiling), 0, 0, {}};
  FloorPlan& plan = storey.plan;
  const bool is_basement = number < 0;
  const std::string prefix = is_basement ? "basement " : number == 0 ? "ground " : "first ";
  storey.corridor = plan.add_room(prefix + "corridor", 0.0, kCorridorSouth, kEast, kCorridorNorth);
  storey.well = plan.add_room(prefix + "stairwell", kWellWest, kCorridorNorth, kWellEast, kNorth);
  plan.connect_at(storey.corridor, storey.well, kWellMiddle, 1.0);

  // Pairs of neighbours, walked through one after the other: south from west to east, north back.
  constexpr std::array<std::array<double, 3>, 4> kPairs = {
      {{0.0, 5.0, 10.0}, {10.0, 15.0, kEast}, {kEast, 15.9, kWellEast}, {kWellWest, 4.1, 0.0}}};
  storey.tour.push_back(storey.corridor);
  int rooms = 0;
  for (std::size_t k = 0; k < kPairs.size(); ++k) {
    const double y0 = k < 2 ? 0.0 : kCorridorNorth;
    const double y1 = k < 2 ? kCorridorSouth : kNorth;
    const auto add = [&](double xa, double xb) {
      const std::string name = prefix + std::to_string(++rooms);
      const int room = plan.add_room(name, std::min(xa, xb), y0, std::max(xa, xb), y1);
      plan.connect(storey.corridor, room, random);
      storey.tour.push_back(room);
      return room;
    };
    if (is_basement) {
      add(kPairs[k][0], kPairs[k][2]);
    } else {
      const int first = add(kPairs[k][0], kPairs[k][1]);
      const int second = add(kPairs[k][1], kPairs[k][2]);
      plan.connect(first, second, random);
    }
    storey.tour.push_back(storey.corridor);
  }
  if (has_windows) plan.add_windows(0.4, random);
  return storey;
}

/// The flight that leads up from a storey: the lower one along the western wall of the stairwell,
/// the upper one along the eastern one.
Flight flight_from(int storey) {
  Flight flight;
  flight.min_x = storey < 0 ? kWellWest + kWallHalf : kWellEast - kWallHalf - kFlightWidth;
  flight.max_x = flight.min_x + kFlightWidth;
  flight.south_y = kFlightSouth;
  flight.floor_m = storey * kStorey;
  flight.height_m = kStorey;
  return flight;
}

void add_stairs(const FloorPlan& upper, int from_storey, std::vector<BoxSolid>* solids) {
  const Flight flight = flight_from(from_storey);
  const bool is_west = from_storey < 0;
  const double floor = flight.top_m();
  const BoxSolid hole = BoxSolid::from_corners_m(
      {flight.min_x - (is_west ? 0.0 : kHoleMargin), kHoleSouth, floor - kSlab},
      {flight.max_x + (is_west ? kHoleMargin : 0.0), flight.north_y(), floor}, 0.0F);
  append_slab_with_hole(upper.slab(floor - kSlab, floor, kFloorAlbedo), hole, solids);
  append_flight(flight, kConcrete, solids);
  append_balustrade(hole, is_west ? HoleWall::kWest : HoleWall::kEast, floor, kConcrete, solids);
}

/// From the corridor of one storey to the corridor of the one above, or back down.
void take_stairs(const Storey& lower, const Storey& upper, int from_storey, bool up,
                 RandomStream* random, PathWriter* path) {
  const Flight flight = flight_from(from_storey);
  const double x = 0.5 * (flight.min_x + flight.max_x);
  constexpr double kBeside = 0.6;
  const auto foot = [&]() {
    path->set_floor(flight.floor_m);
    const std::array<Eigen::Vector2d, 3> places = {
        Eigen::Vector2d(kWellMiddle, kFlightSouth - kBeside),
        {x, kFlightSouth - kBeside},
        {x, kFlightSouth}};
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Eigen::Vector2d& p = places[up ? k : places.size() - 1 - k];
      path->exact(p.x(), p.y());
    }
  };
  const auto head = [&]() {
    path->set_floor(flight.top_m());
    const double landing = flight.north_y() + kBeside;
    const std::array<Eigen::Vector2d, 4> places = {Eigen::Vector2d(x, flight.north_y()),
                                                   {x, landing},
                                                   {kWellMiddle, landing},
                                                   {kWellMiddle, kFlightSouth}};
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Eigen::Vector2d& p = places[up ? k : places.size() - 1 - k];
      path->exact(p.x(), p.y());
    }
  };
  const auto pass = [&](const Storey& storey, bool in) {
    const std::array<int, 2> rooms = {in ? storey.corridor : storey.well,
                                      in ? storey.well : storey.corridor};
    storey.plan.walk(rooms, random, path);
  };
  if (up) {
    pass(lower, true);
    foot();
    head();
    pass(upper, false);
  } else {
    pass(upper, true);
    head();
    foot();
    pass(lower, false);
  }
}

std::vector<Waypoint> walk_storeys(const Storey& basement, const Storey& ground,
                                   const Storey& first, RandomStream* random) {
  PathWriter path(kSensorHeight, random);
  path.exact(kWellMiddle - 1.0, 0.5 * (kCorridorSouth + kCorridorNorth));
  ground.plan.walk(ground.tour, random, &path);
  take_stairs(ground, first, 0, true, random, &path);
  first.plan.walk(first.tour, random, &path);
  take_stairs(ground, first, 0, false, random, &path);
  take_stairs(basement, ground, -1, false, random, &path);
  basement.plan.walk(basement.tour, random, &path);
  take_stairs(basement, ground, -1, true, random, &path);
  path.set_floor(0.0);
  path.exact(kWellMiddle - 1.0, 0.5 * (kCorridorSouth + kCorridorNorth));
  return path.take();
}

std::vector<Piece> pieces_for(const Room& room, RandomStream* random) {
  using enum Piece;
  constexpr std::array kOffice = {kTable, kTable,   kChair, kChair,
                                  kShelf, kCabinet, kSofa,  kLowTable};
  constexpr std::array kStore = {kCrate, kCrate, kCrate, kShelf, kShelf, kWardrobe, kCounter};
  constexpr int kMostPieces = 10;
  if (room.name.ends_with("stairwell")) return {};
  if (room.name.ends_with("corridor")) return {kCabinet, kShelf, kCabinet};
  return room.storey < 0 ? draw_pieces(room, kStore, 2 * kMostPieces, random)
                         : draw_pieces(room, kOffice, kMostPieces, random);
}

}  // namespace

World make_three_storey(std::uint64_t seed) {
  RandomStream layout = random_stream(seed, Purpose::kWorld);
  RandomStream walk = random_stream(seed, Purpose::kPath);
  const std::array<Storey, 3> storeys = {draw_storey(-1, false, &layout),
                                         draw_storey(0, true, &layout),
                                         draw_storey(1, true, &layout)};
  World world;
  world.name = "three-storey";
  std::vector<Eigen::Vector3d> doorways;
  for (const Storey& storey : storeys) {
    storey.plan.append_walls(kPlaster, &world.solids);
    const std::vector<Room> rooms = storey.plan.rooms(static_cast<int>(world.rooms.size()));
    world.rooms.insert(world.rooms.end(), rooms.begin(), rooms.end());
    const std::vector<Eigen::Vector3d> points = storey.plan.doorway_points();
    doorways.insert(doorways.end(), points.begin(), points.end());
  }
  world.solids.push_back(storeys[0].plan.slab(-kStorey - kSlab, -kStorey, kFloorAlbedo));
  add_stairs(storeys[1].plan, -1, &world.solids);
  add_stairs(storeys[2].plan, 0, &world.solids);
  world.solids.push_back(storeys[2].plan.slab(kStorey + kCeiling, 2.0 * kStorey, kFloorAlbedo));
  world.path = walk_storeys(storeys[0], storeys[1], storeys[2], &walk);
  furnish_rooms(
      doorways, [&](const Room& room) { return pieces_for(room, &layout); }, &layout, &world);
  world.mesh = union_surface(world.solids);
  return world;
}

}  // namespace cloister
