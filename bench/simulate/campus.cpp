#include "bench/simulate/campus.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bench/simulate/campus_walk.hpp"
#include "bench/simulate/facade.hpp"
#include "bench/simulate/path_writer.hpp"
#include "bench/simulate/plants.hpp"

namespace cloister {

namespace {

constexpr double kEast = 135.0;
constexpr double kNorth = 122.0;
constexpr double kSouthStreet = 16.0;  ///< streets from here ...
constexpr double kQuadSouth = 30.0;    ///< ... to here, and so on
constexpr double kCourtSouth = 39.0;
constexpr double kCourtNorth = 83.0;
constexpr double kQuadNorth = 92.0;
constexpr double kNorthStreet = 105.0;
constexpr double kCourtWest = 9.0;
constexpr double kCourtEast = 49.0;
constexpr double kQuadEast = 58.0;
constexpr double kParkWest = 70.0;
constexpr double kTunnelSouth = 59.0;
constexpr double kTunnelNorth = 63.0;
constexpr double kTunnelTop = 3.8;
constexpr double kFoundation = -2.0;
constexpr double kTallest = 15.0;

constexpr float kStone = 0.5F;
constexpr float kSteel = 0.35F;
constexpr float kTiles = 0.3F;

/// What is built up one after the other.
struct Site {
  World world;
  TriangleMesh shapes;  ///< plants and roofs
  std::vector<ConvexPart> shape_parts;
  std::vector<Eigen::Vector3d> path_W;  ///< dense

  void box(double x0, double y0, double z0, double x1, double y1, double z1, float albedo) {
    world.solids.push_back(BoxSolid::from_corners_m({x0, y0, z0}, {x1, y1, z1}, albedo));
  }
  /// A box from below the ground to a height above it, the ground taken at its middle.
  void stand(double x0, double y0, double x1, double y1, double height_m, float albedo) {
    const double floor = world.ground->at(0.5 * (x0 + x1), 0.5 * (y0 + y1));
    box(x0, y0, floor - 0.6, x1, y1, floor + height_m, albedo);
  }
  void roof(double x0, double y0, double x1, double y1, double eaves, double ridge) {
    shape_parts.push_back(append_roof(Eigen::Vector3d(x0, y0, eaves).cast<float>(),
                                      Eigen::Vector3d(x1, y1, ridge).cast<float>(), kTiles,
                                      &shapes));
  }
  [[nodiscard]] Eigen::Vector3d on_ground(double x, double y) const {
    return {x, y, world.ground->at(x, y)};
  }
  [[nodiscard]] bool is_clear_of_path(double x, double y, double clearance_m) const {
    return std::none_of(path_W.begin(), path_W.end(), [&](const Eigen::Vector3d& p) {
      return std::hypot(p.x() - x, p.y() - y) < clearance_m;
    });
  }
};

/// Waves of 18 to 60 m in all directions, half a metre up and down.
HeightField make_ground(RandomStream* random) {
  constexpr double kHighest = 0.5;
  struct Wave {
    double u, v, phase, height;
  };
  std::vector<Wave> waves;
  double sum = 0.0;
  for (int k = 0; k < 7; ++k) {
    const double length = random->uniform(18.0, 60.0);
    const double direction = random->uniform(0.0, std::numbers::pi);
    const double number = 2.0 * std::numbers::pi / length;
    waves.push_back({number * std::cos(direction), number * std::sin(direction),
                     random->uniform(0.0, 2.0 * std::numbers::pi), length});
    sum += length;
  }
  return HeightField::sample(kEast, kNorth, 1.0, [&](double x, double y) {
    double z = 0.0;
    for (const Wave& w : waves) z += w.height * std::sin(w.u * x + w.v * y + w.phase);
    return std::clamp(1.8 * z / sum, -1.0, 1.0) * kHighest;
  });
}

float ground_albedo(double x, double y) {
  constexpr float kGrass = 0.45F;
  constexpr float kGravel = 0.35F;
  constexpr float kAsphalt = 0.2F;
  const bool in_court = x > kCourtWest && x < kCourtEast && y > kCourtSouth && y < kCourtNorth;
  if (in_court) {
    const bool in_lawn = x > kCourtWest + 6.0 && x < kCourtEast - 6.0 && y > kCourtSouth + 6.0 &&
                         y < kCourtNorth - 6.0 && std::abs(y - 61.0) > 1.5;
    return in_lawn ? kGrass : kGravel;
  }
  return x > kParkWest && y > kQuadSouth && y < kQuadNorth ? kGrass : kAsphalt;
}

void build_quad(RandomStream* random, Site* site) {
  const auto wing = [&](double x0, double y0, double x1, double y1, std::array<bool, 4> windows,
                        double height) {
    append_block({x0, y0, x1, y1, height, random->uniform(2.9, 3.6), windows}, random,
                 &site->world.solids);
    site->roof(x0, y0, x1, y1, height, height + random->uniform(2.0, 3.0));
  };
  const auto height = [&]() { return random->uniform(8.6, 10.8); };
  wing(0.0, kQuadSouth, kQuadEast, kCourtSouth, {true, true, true, false}, height());
  wing(0.0, kCourtNorth, kQuadEast, kQuadNorth, {true, true, true, false}, height());
  wing(0.0, kCourtSouth, kCourtWest, kCourtNorth, {false, true, false, false}, height());
  const double east = height();
  wing(kCourtEast, kCourtSouth, kQuadEast, kTunnelSouth, {false, true, false, true}, east);
  wing(kCourtEast, kTunnelNorth, kQuadEast, kCourtNorth, {false, true, false, true}, east);

  // The gatehouse above the tunnel, its vault in steps, pilasters along its walls.
  const double top = random->uniform(13.5, kTallest);
  site->box(kCourtEast, kTunnelSouth, kTunnelTop, kQuadEast, kTunnelNorth, top, kStone);
  site->box(kCourtEast - 0.4, kTunnelSouth - 2.0, kTunnelTop + 1.0, kQuadEast + 0.4,
            kTunnelNorth + 2.0, top, kStone);
  constexpr std::array<std::array<double, 2>, 4> kVault = {
      {{0.95, 3.6}, {0.55, 3.3}, {0.28, 2.95}, {0.12, 2.55}}};
  for (const auto& [width, from] : kVault) {
    site->box(kCourtEast, kTunnelSouth, from, kQuadEast, kTunnelSouth + width, kTunnelTop, kStone);
    site->box(kCourtEast, kTunnelNorth - width, from, kQuadEast, kTunnelNorth, kTunnelTop, kStone);
  }
  for (double x = kCourtEast + 0.2; x < kQuadEast - 0.5; x += 2.05) {
    site->box(x, kTunnelSouth, kFoundation, x + 0.4, kTunnelSouth + 0.18, 2.55, kStone);
    site->box(x, kTunnelNorth - 0.18, kFoundation, x + 0.4, kTunnelNorth, 2.55, kStone);
  }
}

/// A row of houses of different heights and roofs.
void build_row(double y0, double y1, bool faces_south, RandomStream* random, Site* site) {
  for (double x = 0.0; x < kEast;) {
    const double left = kEast - x;
    const double width = left < 30.0 ? left : random->uniform(13.0, 24.0);
    const double height = random->uniform(7.5, kTallest - 0.5);
    append_block({x,
                  y0 + (faces_south ? random->uniform(0.0, 0.8) : 0.0),
                  x + width,
                  y1 - (faces_south ? 0.0 : random->uniform(0.0, 0.8)),
                  height,
                  random->uniform(2.4, 3.8),
                  {faces_south, false, !faces_south, false}},
                 random, &site->world.solids);
    if (height < 12.0) site->roof(x, y0 + 0.9, x + width, y1 - 0.9, height, height + 2.5);
    x += width;
  }
}

/// Bars at every hand's breadth between a low and a high rail, in pieces as long as the ground is
/// even.
void add_railing(double x0, double y0, double x1, double y1, Site* site) {
  constexpr double kPiece_m = 2.0;
  constexpr double kBar_m = 0.025;
  const Eigen::Vector2d from(x0, y0);
  const Eigen::Vector2d step(x1 - x0, y1 - y0);
  const int pieces = std::max(1, static_cast<int>(step.norm() / kPiece_m));
  for (int piece = 0; piece < pieces; ++piece) {
    const Eigen::Vector2d a = from + step * piece / pieces;
    const Eigen::Vector2d b = from + step * (piece + 1) / pieces;
    const double floor = site->world.ground->at(0.5 * (a.x() + b.x()), 0.5 * (a.y() + b.y()));
    for (const double z : {0.15, 1.05}) {
      site->box(a.x() - 0.02, a.y() - 0.02, floor + z, b.x() + 0.02, b.y() + 0.02, floor + z + 0.04,
                kSteel);
    }
    constexpr int kBars = 16;
    for (int bar = 0; bar < kBars; ++bar) {
      const Eigen::Vector2d p = a + (b - a) * bar / kBars;
      const double half = bar == 0 ? kBar_m : 0.5 * kBar_m;
      site->box(p.x() - half, p.y() - half, floor + (bar == 0 ? -0.5 : 0.15), p.x() + half,
                p.y() + half, floor + 1.09, kSteel);
    }
  }
}

void add_bounds(RandomStream* random, Site* site) {
  constexpr double kWall = 0.3;
  const auto wall = [&](double x0, double y0, double x1, double y1, double top) {
    site->box(x0, y0, kFoundation, x1, y1, top, kStone);
  };
  wall(0.0, kSouthStreet, kWall, kQuadSouth, 2.4);
  wall(0.0, kQuadNorth, kWall, kNorthStreet, 2.4);
  wall(kEast - kWall, kSouthStreet, kEast, kNorthStreet, 2.8);
  // The park's low wall to the south and its hedges, with gaps where one goes in.
  wall(kParkWest, kQuadSouth, 99.0, kQuadSouth + kWall, 0.8);
  wall(103.0, kQuadSouth, kEast, kQuadSouth + kWall, 0.8);
  const auto hedge = [&](double x0, double y0, double x1, double y1) {
    append_hedge(site->on_ground(x0, y0), site->on_ground(x1, y1), 0.9, random->uniform(1.1, 1.5),
                 random, &site->shapes, &site->shape_parts);
  };
  for (double x = kParkWest; x < kEast - 1.0; x += 6.0) {
    if (x < 106.0 || x > 111.0) hedge(x, kQuadNorth, std::min(x + 6.0, kEast - 0.5), kQuadNorth);
  }
  for (const double y : {33.0, 39.0, 77.0, 83.0}) hedge(kParkWest, y, kParkWest, y + 6.0);
  add_railing(kParkWest, 45.0, kParkWest, 59.0, site);
  add_railing(kParkWest, 63.0, kParkWest, 77.0, site);
  add_railing(15.5, 45.5, 42.5, 45.5, site);
}

void plant_trees(RandomStream* random, Site* site) {
  constexpr int kAttempts = 4000;
  constexpr std::size_t kParkTrees = 46;
  std::vector<Eigen::Vector2d> trunks;
  const auto try_plant = [&](double x, double y, double apart_m) {
    const bool is_apart = std::none_of(trunks.begin(), trunks.end(), [&](const auto& t) {
      return (t - Eigen::Vector2d(x, y)).norm() < apart_m;
    });
    if (!is_apart || !site->is_clear_of_path(x, y, 1.3)) return;
    trunks.emplace_back(x, y);
    append_tree(site->on_ground(x, y), random, &site->shapes, &site->shape_parts);
  };
  for (int k = 0; k < kAttempts && trunks.size() < kParkTrees; ++k) {
    try_plant(random->uniform(73.0, kEast - 3.5), random->uniform(33.0, kQuadNorth - 2.0), 4.2);
  }
  for (double y = 36.0; y < 90.0; y += 12.0) try_plant(68.0, y + random->uniform(-1.5, 1.5), 4.0);
  for (const double x : {22.0, 36.0}) {
    for (const double y : {52.0, 70.0}) {
      try_plant(x + random->uniform(-2.0, 2.0), y + random->uniform(-2.0, 2.0), 4.0);
    }
  }
}

/// Lamps and benches where nobody walks.
void add_street_furniture(RandomStream* random, Site* site) {
  const auto lamp = [&](double x, double y) {
    if (!site->is_clear_of_path(x, y, 0.9)) return;
    const double height = random->uniform(3.8, 4.6);
    site->stand(x - 0.07, y - 0.07, x + 0.07, y + 0.07, height, kSteel);
    site->stand(x - 0.2, y - 0.2, x + 0.2, y + 0.2, 0.25, kStone);
    const double floor = site->world.ground->at(x, y);
    site->box(x - 0.22, y - 0.22, floor + height, x + 0.22, y + 0.22, floor + height + 0.4, kSteel);
  };
  for (double x = 6.0; x < kEast; x += 16.0) {
    lamp(x + random->uniform(-1.0, 1.0), 18.5);
    lamp(x + random->uniform(-1.0, 1.0), 102.5);
    if (x > kParkWest) lamp(x, random->uniform(40.0, 80.0));
  }
  for (double y = 34.0; y < kQuadNorth; y += 14.0) lamp(59.8, y + random->uniform(-1.0, 1.0));

  const auto bench = [&](double x, double y) {
    if (!site->is_clear_of_path(x + 0.9, y + 0.25, 1.9)) return;
    const double floor = site->world.ground->at(x + 0.9, y + 0.25);
    site->box(x, y, floor + 0.42, x + 1.8, y + 0.45, floor + 0.47, kTiles);
    site->box(x, y + 0.45, floor + 0.42, x + 1.8, y + 0.5, floor + 0.9, kTiles);
    for (const double leg : {0.1, 1.6}) {
      site->box(x + leg, y + 0.05, floor - 0.6, x + leg + 0.08, y + 0.45, floor + 0.42, kTiles);
    }
  };
  for (int k = 0; k < 14; ++k) bench(random->uniform(74.0, 128.0), random->uniform(34.0, 88.0));
  for (const double x : {18.0, 28.0, 38.0}) bench(x, 40.2 + random->uniform(0.0, 0.3));
}

std::vector<Room> list_areas() {
  constexpr double kLow = -0.6;
  constexpr double kHigh = 8.0;
  std::vector<Room> areas;
  const auto add = [&](const char* name, double x0, double y0, double x1, double y1, double high) {
    areas.push_back({static_cast<int>(areas.size()), name, 0, {x0, y0, kLow}, {x1, y1, high}});
  };
  add("quad", kCourtWest, kCourtSouth, kCourtEast, kCourtNorth, kHigh);
  add("tunnel", kCourtEast, kTunnelSouth, kQuadEast, kTunnelNorth, kTunnelTop);
  add("east street", kQuadEast, kQuadSouth, kParkWest, kQuadNorth, kHigh);
  add("park", kParkWest, kQuadSouth, kEast, kQuadNorth, kHigh);
  add("north street", 0.0, kQuadNorth, kEast, kNorthStreet, kHigh);
  add("south street", 0.0, kSouthStreet, kEast, kQuadSouth, kHigh);
  return areas;
}

/// Appends a mesh and the parts that are ranges of it.
void append_parts(const TriangleMesh& mesh, const std::vector<ConvexPart>& parts, World* world) {
  const auto vertices = static_cast<std::uint32_t>(world->mesh.vertices.size());
  const auto triangles = static_cast<std::uint32_t>(world->mesh.triangles.size());
  world->mesh.vertices.insert(world->mesh.vertices.end(), mesh.vertices.begin(),
                              mesh.vertices.end());
  world->mesh.albedo.insert(world->mesh.albedo.end(), mesh.albedo.begin(), mesh.albedo.end());
  for (const auto& t : mesh.triangles)
    world->mesh.triangles.push_back({t[0] + vertices, t[1] + vertices, t[2] + vertices});
  for (ConvexPart part : parts) {
    part.first_triangle += triangles;
    world->parts.push_back(part);
  }
}

}  // namespace

World make_campus(std::uint64_t seed) {
  RandomStream layout = random_stream(seed, Purpose::kWorld);
  RandomStream walk = random_stream(seed, Purpose::kPath);
  Site site;
  site.world.name = "campus";
  site.world.sensor = "os1-64";
  site.world.ground = make_ground(&layout);
  site.world.rooms = list_areas();
  site.world.path = walk_campus(*site.world.ground, &walk);
  site.path_W = densify(site.world.path, 0.5);
  build_quad(&layout, &site);
  build_row(0.0, kSouthStreet, false, &layout, &site);
  build_row(kNorthStreet, kNorth, true, &layout, &site);
  add_bounds(&layout, &site);
  plant_trees(&layout, &site);
  add_street_furniture(&layout, &site);
  site.world.mesh = union_surface(site.world.solids);
  site.world.ground->append_to(ground_albedo, &site.world.mesh);
  append_parts(site.shapes, site.shape_parts, &site.world);
  return std::move(site.world);
}

}  // namespace cloister
