#include "bench/simulate/small_rooms.hpp"

#include <algorithm>
#include <array>

#include "bench/simulate/floor_plan.hpp"

namespace cloister {

namespace {

constexpr double kSensorHeight = 1.1;
constexpr double kCeiling = 2.6;
constexpr double kSlab = 0.25;
constexpr int kRoundsEachWay = 3;
constexpr float kPlaster = 0.7F;
constexpr float kFloorAlbedo = 0.35F;

/// Rooms by their place in the plan, row by row from the south-west: A B C, H M D, G F E.
enum : int { kA, kB, kC, kH, kM, kD, kG, kF, kE };

std::array<double, 4> draw_lines(RandomStream* random) {
  std::array<double, 4> lines = {};
  for (std::size_t k = 1; k < lines.size(); ++k)
    lines[k] = lines[k - 1] + random->uniform(4.0, 5.0);
  return lines;
}

FloorPlan draw_plan(RandomStream* random) {
  FloorPlan plan(0, 0.0, kCeiling);
  const auto x = draw_lines(random);
  const auto y = draw_lines(random);
  constexpr std::array<const char*, 9> kNames = {"A", "B", "C", "H", "middle", "D", "G", "F", "E"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const std::size_t i = k % 3;
    const std::size_t j = k / 3;
    plan.add_room(kNames[k], x[i], y[j], x[i + 1], y[j + 1]);
  }
  constexpr std::array<int, 9> kRing = {kA, kB, kC, kD, kE, kF, kG, kH, kA};
  for (std::size_t k = 1; k < kRing.size(); ++k) plan.connect(kRing[k - 1], kRing[k], random);
  plan.connect(kH, kM, random);
  plan.connect(kM, kB, random);
  for (const int room : {kD, kF}) {
    if (random->uniform() < 0.5) plan.connect(kM, room, random);
  }
  plan.add_windows(0.35, random);
  return plan;
}

std::vector<Waypoint> walk_rounds(const FloorPlan& plan, const Room& start, RandomStream* random) {
  PathWriter path(kSensorHeight, random);
  const Eigen::Vector3d middle = 0.5 * (start.min_W + start.max_W);
  path.exact(middle.x() - 0.4, middle.y() - 0.4);
  std::vector<int> round = {kA, kB, kC, kD, kE, kF, kG, kH, kM, kB, kA};
  for (int lap = 0; lap < 2 * kRoundsEachWay; ++lap) {
    if (lap == kRoundsEachWay) std::reverse(round.begin(), round.end());
    plan.walk(round, random, &path);
    path.around(middle.x(), middle.y(), 0.0, 0.3);
  }
  return path.take();
}

}  // namespace

World make_small_rooms(std::uint64_t seed) {
  using enum Piece;
  constexpr std::array kKinds = {kTable, kLowTable, kChair,    kChair,   kShelf,
                                 kBed,   kSofa,     kWardrobe, kCabinet, kCrate};
  constexpr int kMostPieces = 9;
  RandomStream layout = random_stream(seed, Purpose::kWorld);
  RandomStream walk = random_stream(seed, Purpose::kPath);
  const FloorPlan plan = draw_plan(&layout);
  World world;
  world.name = "small-rooms";
  world.rooms = plan.rooms(0);
  world.path = walk_rounds(plan, world.rooms.front(), &walk);
  plan.append_walls(kPlaster, &world.solids);
  world.solids.push_back(plan.slab(-kSlab, 0.0, kFloorAlbedo));
  world.solids.push_back(plan.slab(kCeiling, kCeiling + kSlab, kFloorAlbedo));
  furnish_rooms(
      plan.doorway_points(),
      [&](const Room& room) { return draw_pieces(room, kKinds, kMostPieces, &layout); }, &layout,
      &world);
  world.mesh = union_surface(world.solids);
  return world;
}

}  // namespace cloister
