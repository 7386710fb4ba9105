#include "bench/simulate/furniture.hpp"

#include <algorithm>
#include <array>

namespace cloister {

namespace {

/// A piece in its own frame: x along the wall from 0 to `width`, y away from it from 0 to `depth`,
/// z up from the floor.
struct Design {
  double width = 0.0;
  double depth = 0.0;
  bool against_wall = true;
  std::vector<std::array<double, 6>> blocks;  ///< min x, y, z, max x, y, z

  void block(double x0, double y0, double z0, double x1, double y1, double z1) {
    blocks.push_back({x0, y0, z0, x1, y1, z1});
  }
};

void add_legs(double leg, double height, Design* design) {
  const double w = design->width;
  const double d = design->depth;
  design->block(0.0, 0.0, 0.0, leg, leg, height);
  design->block(w - leg, 0.0, 0.0, w, leg, height);
  design->block(0.0, d - leg, 0.0, leg, d, height);
  design->block(w - leg, d - leg, 0.0, w, d, height);
}

Design design_of(Piece piece, RandomStream* random) {
  Design d;
  switch (piece) {
    case Piece::kTable:
    case Piece::kLowTable: {
      const bool low = piece == Piece::kLowTable;
      d.width = low ? random->uniform(0.8, 1.1) : random->uniform(1.2, 1.7);
      d.depth = low ? random->uniform(0.5, 0.6) : random->uniform(0.7, 0.85);
      d.against_wall = !low;
      const double height = low ? 0.44 : 0.74;
      d.block(0.0, 0.0, height - 0.04, d.width, d.depth, height);
      add_legs(0.06, height - 0.04, &d);
      break;
    }
    case Piece::kChair:
      d.width = 0.44;
      d.depth = 0.46;
      d.against_wall = false;
      d.block(0.0, 0.0, 0.42, 0.44, 0.46, 0.47);
      d.block(0.0, 0.0, 0.47, 0.44, 0.04, 0.92);
      add_legs(0.04, 0.42, &d);
      break;
    case Piece::kShelf: {
      d.width = random->uniform(0.8, 1.4);
      d.depth = random->uniform(0.28, 0.38);
      const double height = random->uniform(1.6, 2.0);
      d.block(0.0, 0.0, 0.0, d.width, 0.02, height);
      d.block(0.0, 0.02, 0.0, 0.03, d.depth, height);
      d.block(d.width - 0.03, 0.02, 0.0, d.width, d.depth, height);
      for (int board = 0; board <= 4; ++board) {
        const double z = 0.05 + (height - 0.08) * board / 4.0;
        d.block(0.03, 0.02, z, d.width - 0.03, d.depth, z + 0.03);
      }
      break;
    }
    case Piece::kBed:
      d.width = random->uniform(1.0, 1.6);
      d.depth = 2.05;
      d.block(0.0, 0.0, 0.0, d.width, 0.06, 1.0);
      d.block(0.0, 0.06, 0.0, d.width, d.depth, 0.48);
      break;
    case Piece::kSofa:
      d.width = random->uniform(1.6, 2.1);
      d.depth = 0.88;
      d.block(0.0, 0.0, 0.0, d.width, 0.22, 0.82);
      d.block(0.0, 0.22, 0.0, 0.18, d.depth, 0.62);
      d.block(d.width - 0.18, 0.22, 0.0, d.width, d.depth, 0.62);
      d.block(0.18, 0.22, 0.0, d.width - 0.18, d.depth, 0.43);
      break;
    case Piece::kWardrobe:
      d.width = random->uniform(1.0, 1.5);
      d.depth = 0.6;
      d.block(0.0, 0.0, 0.0, d.width, d.depth, random->uniform(1.9, 2.2));
      break;
    case Piece::kCounter:
      d.width = random->uniform(1.8, 2.4);
      d.depth = 0.6;
      d.block(0.0, 0.0, 0.0, d.width, 0.56, 0.88);
      d.block(0.0, 0.0, 0.88, d.width, 0.6, 0.92);
      break;
    case Piece::kCabinet:
      d.width = random->uniform(0.7, 1.1);
      d.depth = random->uniform(0.32, 0.42);
      d.block(0.0, 0.0, 0.0, d.width, d.depth, random->uniform(0.7, 1.1));
      break;
    case Piece::kTub:
      d.width = 1.7;
      d.depth = 0.75;
      d.block(0.0, 0.0, 0.0, 1.7, 0.06, 0.56);
      d.block(0.0, 0.69, 0.0, 1.7, 0.75, 0.56);
      d.block(0.0, 0.06, 0.0, 0.06, 0.69, 0.56);
      d.block(1.64, 0.06, 0.0, 1.7, 0.69, 0.56);
      d.block(0.06, 0.06, 0.0, 1.64, 0.69, 0.14);
      break;
    case Piece::kCrate: {
      const double edge = random->uniform(0.35, 0.6);
      d.width = edge;
      d.depth = edge;
      d.block(0.0, 0.0, 0.0, edge, edge, edge * random->uniform(0.8, 1.3));
      break;
    }
  }
  return d;
}

/// A piece's place: its outline seen from above, and which way its back is turned.
struct Footprint {
  int back = 0;  ///< 0: towards -y, 1: +x, 2: +y, 3: -x
  Eigen::Vector2d min = Eigen::Vector2d::Zero();
  Eigen::Vector2d max = Eigen::Vector2d::Zero();

  [[nodiscard]] double distance(const Eigen::Vector2d& p) const {
    return (p - p.cwiseMax(min).cwiseMin(max)).norm();
  }
  [[nodiscard]] bool is_near(const Footprint& other, double gap) const {
    return ((min.array() - gap) < other.max.array()).all() &&
           ((other.min.array() - gap) < max.array()).all();
  }
};

Footprint propose(const Room& room, const Design& design, RandomStream* random) {
  Footprint place;
  place.back = static_cast<int>(random->below(4));
  const bool turned = place.back % 2 == 1;
  const Eigen::Vector2d size(turned ? design.depth : design.width,
                             turned ? design.width : design.depth);
  const Eigen::Vector2d low = room.min_W.head<2>();
  const Eigen::Vector2d room_left = room.max_W.head<2>() - low - size;
  place.min =
      low + Eigen::Vector2d(random->uniform() * room_left.x(), random->uniform() * room_left.y());
  if (design.against_wall) {
    if (place.back == 0) place.min.y() = low.y();
    if (place.back == 1) place.min.x() = low.x() + room_left.x();
    if (place.back == 2) place.min.y() = low.y() + room_left.y();
    if (place.back == 3) place.min.x() = low.x();
  }
  place.max = place.min + size;
  return place;
}

/// A point of the piece's own frame, placed in the room.
Eigen::Vector3d to_room(const Footprint& place, double floor_z, double x, double y, double z) {
  switch (place.back) {
    case 0:
      return {place.min.x() + x, place.min.y() + y, floor_z + z};
    case 1:
      return {place.max.x() - y, place.min.y() + x, floor_z + z};
    case 2:
      return {place.max.x() - x, place.max.y() - y, floor_z + z};
    default:
      return {place.min.x() + y, place.max.y() - x, floor_z + z};
  }
}

}  // namespace

void furnish(const Room& room, std::span<const Piece> pieces,
             std::span<const Eigen::Vector3d> path_W, double clearance_m, RandomStream* random,
             std::vector<BoxSolid>* solids) {
  constexpr int kAttempts = 200;
  constexpr double kGap = 0.12;
  std::vector<Eigen::Vector2d> keep_free;
  for (const Eigen::Vector3d& p : path_W) {
    if (room.contains(p, -clearance_m)) keep_free.push_back(p.head<2>());
  }
  std::vector<Footprint> taken;
  for (const Piece piece : pieces) {
    const Design design = design_of(piece, random);
    const auto albedo = static_cast<float>(random->uniform(0.12, 0.8));
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Footprint place = propose(room, design, random);
      const bool fits = (place.min.array() >= room.min_W.head<2>().array()).all();
      const bool blocks_path =
          std::any_of(keep_free.begin(), keep_free.end(),
                      [&](const Eigen::Vector2d& p) { return place.distance(p) < clearance_m; });
      const bool collides = std::any_of(taken.begin(), taken.end(), [&](const Footprint& other) {
        return place.is_near(other, kGap);
      });
      if (!fits || blocks_path || collides) continue;
      taken.push_back(place);
      const double floor_z = room.min_W.z();
      for (const auto& b : design.blocks) {
        solids->push_back(BoxSolid::from_corners_m(to_room(place, floor_z, b[0], b[1], b[2]),
                                                   to_room(place, floor_z, b[3], b[4], b[5]),
                                                   albedo));
      }
      break;
    }
  }
}

}  // namespace cloister
