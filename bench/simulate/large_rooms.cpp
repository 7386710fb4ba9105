#include "bench/simulate/large_rooms.hpp"

#include <algorithm>
#include <array>

#include "bench/simulate/floor_plan.hpp"

namespace cloister {

namespace {

constexpr double kSensorHeight = 1.1;
constexpr double kCeiling = 3.0;
constexpr double kSlab = 0.25;
constexpr double kHallWidth = 12.0;
constexpr double kCorridor = 2.2;
constexpr double kBlockWidth = 10.0;
constexpr double kRowDepth = 6.0;
constexpr double kSouth = kRowDepth + kCorridor;
constexpr double kHallDepth = 18.0;
constexpr double kNorth = kSouth + kHallDepth;
constexpr double kTop = kNorth + kCorridor + kRowDepth;
constexpr double kEast = 3.0 * kHallWidth + 2.0 * (kCorridor + kBlockWidth);
constexpr std::size_t kRowRooms = 13;
constexpr std::size_t kBlockRows = 4;
constexpr float kPlaster = 0.7F;
constexpr float kFloorAlbedo = 0.35F;

using Tour = std::vector<int>;

/// One half of the plan: what lies on one side of the middle hall. Rooms of the block by row, from
/// the south.
struct Side {
  int hall = 0;
  int corridor = 0;
  std::array<int, kBlockRows> outer = {};  ///< beside the corridor
  std::array<int, kBlockRows> inner = {};  ///< beside the middle hall
};

struct Layout {
  FloorPlan plan{0, 0.0, kCeiling};
  int middle = 0;
  int south_corridor = 0;
  int north_corridor = 0;
  std::array<int, kRowRooms> south = {};  ///< from west to east
  std::array<int, kRowRooms> north = {};
  Side west, east;
};

/// A row of rooms along a corridor. Neighbours are joined but for the two halves of the row, the
/// rooms at the halves' ends and about every third of the others open to the corridor.
void add_row(const char* name, double y0, double y1, int corridor, RandomStream* random,
             FloorPlan* plan, std::array<int, kRowRooms>* row) {
  constexpr std::size_t kHalf = kRowRooms / 2;
  for (std::size_t k = 0; k < kRowRooms; ++k) {
    const double width = kEast / kRowRooms;
    (*row)[k] =
        plan->add_room(std::string(name) + " " + std::to_string(k + 1),
                       width * static_cast<double>(k), y0, width * static_cast<double>(k + 1), y1);
    const bool is_end = k == 0 || k == kHalf - 1 || k == kHalf || k == kRowRooms - 1;
    if (k > 0 && k != kHalf) plan->connect((*row)[k - 1], (*row)[k], random);
    if (is_end || random->uniform() < 0.35) plan->connect(corridor, (*row)[k], random);
  }
}

void add_side(const std::string& name, bool is_west, RandomStream* random, Layout* layout,
              Side* side) {
  FloorPlan& plan = layout->plan;
  // x as seen from the west; the eastern side is its mirror image.
  const auto add = [&](const std::string& what, double x0, double y0, double x1, double y1) {
    return plan.add_room(name + " " + what, is_west ? x0 : kEast - x1, y0,
                         is_west ? x1 : kEast - x0, y1);
  };
  constexpr double kBlock = kHallWidth + kCorridor;
  constexpr double kRow = kHallDepth / kBlockRows;
  side->hall = add("hall", 0.0, kSouth, kHallWidth, kNorth);
  side->corridor = add("corridor", kHallWidth, kSouth, kBlock, kNorth);
  for (std::size_t k = 0; k < kBlockRows; ++k) {
    const double y = kSouth + kRow * static_cast<double>(k);
    const std::string number = std::to_string(k + 1);
    side->outer[k] = add("outer " + number, kBlock, y, kBlock + 0.5 * kBlockWidth, y + kRow);
    side->inner[k] =
        add("inner " + number, kBlock + 0.5 * kBlockWidth, y, kBlock + kBlockWidth, y + kRow);
    plan.connect(side->corridor, side->outer[k], random);
    plan.connect(side->outer[k], side->inner[k], random);
    plan.connect(side->inner[k], layout->middle, random);
  }
  constexpr double kWide = 1.6;
  const double middle_of_corridor = kHallWidth + 0.5 * kCorridor;
  for (const int along : {layout->south_corridor, layout->north_corridor}) {
    plan.connect_at(side->corridor, along,
                    is_west ? middle_of_corridor : kEast - middle_of_corridor, kWide);
    plan.connect(side->hall, along, random, 1.2);
  }
  if (random->uniform() < 0.5) plan.connect(side->hall, side->corridor, random);
}

Layout draw_layout(RandomStream* random) {
  Layout layout;
  FloorPlan& plan = layout.plan;
  constexpr double kMiddleWest = kHallWidth + kCorridor + kBlockWidth;
  layout.middle =
      plan.add_room("middle hall", kMiddleWest, kSouth, kMiddleWest + kHallWidth, kNorth);
  layout.south_corridor = plan.add_room("south corridor", 0.0, kRowDepth, kEast, kSouth);
  layout.north_corridor = plan.add_room("north corridor", 0.0, kNorth, kEast, kNorth + kCorridor);
  plan.connect(layout.middle, layout.south_corridor, random, 1.2);
  plan.connect(layout.middle, layout.north_corridor, random, 1.2);
  add_row("south", 0.0, kRowDepth, layout.south_corridor, random, &plan, &layout.south);
  add_row("north", kTop - kRowDepth, kTop, layout.north_corridor, random, &plan, &layout.north);
  add_side("west", true, random, &layout, &layout.west);
  add_side("east", false, random, &layout, &layout.east);
  plan.add_windows(0.3, random);
  return layout;
}

/// Ten ways from the middle hall and back to it.
std::vector<Tour> list_tours(const Layout& l) {
  std::vector<Tour> tours;
  const auto half_of_row = [&](const auto& row, int corridor, std::size_t from, std::size_t to) {
    Tour tour = {l.middle, corridor};
    for (std::size_t k = from; k < to; ++k) tour.push_back(row[k]);
    tour.insert(tour.end(), {corridor, l.middle});
    tours.push_back(std::move(tour));
  };
  constexpr std::size_t kHalf = kRowRooms / 2;
  half_of_row(l.south, l.south_corridor, 0, kHalf);
  half_of_row(l.south, l.south_corridor, kHalf, kRowRooms);
  half_of_row(l.north, l.north_corridor, 0, kHalf);
  half_of_row(l.north, l.north_corridor, kHalf, kRowRooms);
  for (const Side* side : {&l.west, &l.east}) {
    for (std::size_t k = 0; k < kBlockRows; k += 2) {
      tours.push_back({l.middle, side->inner[k], side->outer[k], side->corridor, side->outer[k + 1],
                       side->inner[k + 1], l.middle});
    }
    tours.push_back({l.middle, l.south_corridor, side->hall, l.north_corridor, l.middle});
  }
  return tours;
}

std::vector<Waypoint> walk_tours(const Layout& layout, const Room& middle, RandomStream* random) {
  std::vector<Tour> tours = list_tours(layout);
  for (std::size_t k = tours.size(); k > 1; --k) std::swap(tours[k - 1], tours[random->below(k)]);
  PathWriter path(kSensorHeight, random);
  const Eigen::Vector3d center = 0.5 * (middle.min_W + middle.max_W);
  path.around(center.x(), center.y(), 0.0, 1.0);
  for (Tour& tour : tours) {
    if (random->uniform() < 0.5) std::reverse(tour.begin(), tour.end());
    layout.plan.walk(tour, random, &path);
    path.around(center.x(), center.y(), random->uniform(0.0, 2.0), 1.0);
  }
  return path.take();
}

std::vector<Piece> pieces_for(const Room& room, RandomStream* random) {
  using enum Piece;
  constexpr std::array kOffice = {kTable, kTable, kChair,   kChair, kShelf,
                                  kSofa,  kCrate, kCabinet, kShelf, kLowTable};
  constexpr std::array kHall = {kTable, kChair, kChair, kShelf, kCrate, kCounter, kLowTable, kSofa};
  if (room.name.ends_with("corridor")) return {kCabinet, kCabinet, kShelf};
  const bool is_hall = room.name.ends_with("hall");
  return is_hall ? draw_pieces(room, kHall, 40, random) : draw_pieces(room, kOffice, 9, random);
}

}  // namespace

World make_large_rooms(std::uint64_t seed) {
  RandomStream draw = random_stream(seed, Purpose::kWorld);
  RandomStream walk = random_stream(seed, Purpose::kPath);
  const Layout layout = draw_layout(&draw);
  World world;
  world.name = "large-rooms";
  world.rooms = layout.plan.rooms(0);
  world.path = walk_tours(layout, world.rooms[static_cast<std::size_t>(layout.middle)], &walk);
  layout.plan.append_walls(kPlaster, &world.solids);
  world.solids.push_back(layout.plan.slab(-kSlab, 0.0, kFloorAlbedo));
  world.solids.push_back(layout.plan.slab(kCeiling, kCeiling + kSlab, kFloorAlbedo));
  furnish_rooms(
      layout.plan.doorway_points(), [&](const Room& room) { return pieces_for(room, &draw); },
      &draw, &world);
  world.mesh = union_surface(world.solids);
  return world;
}

}  // namespace cloister
