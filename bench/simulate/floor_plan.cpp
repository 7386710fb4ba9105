#include "bench/simulate/floor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace cloister {

namespace {

constexpr double kWall_m = 0.14;
constexpr double kEpsilon_m = 1e-6;
constexpr double kNarrow_m = 2.8;  ///< corridors
constexpr double kHall_m2 = 80.0;

bool is_same(double a, double b) { return std::abs(a - b) < kEpsilon_m; }

}  // namespace

int FloorPlan::add_room(std::string name, double min_x, double min_y, double max_x, double max_y) {
  areas_.push_back({std::move(name), min_x, min_y, max_x, max_y});
  return static_cast<int>(areas_.size()) - 1;
}

FloorPlan::SharedWall FloorPlan::shared_wall(int a, int b) const {
  const Area& p = areas_[static_cast<std::size_t>(a)];
  const Area& q = areas_[static_cast<std::size_t>(b)];
  const bool along_y = is_same(p.max_x, q.min_x) || is_same(p.min_x, q.max_x);
  if (along_y) {
    return {false, is_same(p.max_x, q.min_x) ? p.max_x : p.min_x, std::max(p.min_y, q.min_y),
            std::min(p.max_y, q.max_y)};
  }
  return {true, is_same(p.max_y, q.min_y) ? p.max_y : p.min_y, std::max(p.min_x, q.min_x),
          std::min(p.max_x, q.max_x)};
}

void FloorPlan::connect(int a, int b, RandomStream* random, double width_m) {
  constexpr double kFromEnd_m = 0.5;
  const SharedWall wall = shared_wall(a, b);
  const double reach =
      std::min(0.9, 0.5 * (wall.to_m - wall.from_m - width_m) - kFromEnd_m - 0.5 * kWall_m);
  connect_at(a, b, 0.5 * (wall.from_m + wall.to_m) + random->uniform(-reach, reach), width_m);
}

void FloorPlan::connect_at(int a, int b, double center_m, double width_m) {
  const SharedWall wall = shared_wall(a, b);
  doorways_.push_back({a, b, wall.along_x, wall.line_m, {center_m, width_m, 0.0, 2.0}});
}

FloorPlan::Area FloorPlan::outline() const {
  Area all = areas_.front();
  for (const Area& area : areas_) {
    all.min_x = std::min(all.min_x, area.min_x);
    all.min_y = std::min(all.min_y, area.min_y);
    all.max_x = std::max(all.max_x, area.max_x);
    all.max_y = std::max(all.max_y, area.max_y);
  }
  return all;
}

void FloorPlan::add_windows(double share, RandomStream* random) {
  const Area all = outline();
  for (const Area& area : areas_) {
    const auto side = [&](bool along_x, double line, double outer, double from, double to) {
      if (!is_same(line, outer) || to - from < 2.0 || random->uniform() >= share) return;
      windows_.push_back({along_x, line, {0.5 * (from + to), 1.2, 0.95, 2.1}});
    };
    side(true, area.min_y, all.min_y, area.min_x, area.max_x);
    side(true, area.max_y, all.max_y, area.min_x, area.max_x);
    side(false, area.min_x, all.min_x, area.min_y, area.max_y);
    side(false, area.max_x, all.max_x, area.min_y, area.max_y);
  }
}

void FloorPlan::append_walls(float albedo, std::vector<BoxSolid>* solids) const {
  // Edges by line, in micrometres so that equal ones meet; overlapping edges make one wall.
  using Line = std::pair<bool, std::int64_t>;
  std::map<Line, std::vector<std::pair<double, double>>> edges;
  const auto add = [&](bool along_x, double line, double from, double to) {
    edges[{along_x, std::llround(line * 1e6)}].emplace_back(from, to);
  };
  for (const Area& area : areas_) {
    add(true, area.min_y, area.min_x, area.max_x);
    add(true, area.max_y, area.min_x, area.max_x);
    add(false, area.min_x, area.min_y, area.max_y);
    add(false, area.max_x, area.min_y, area.max_y);
  }
  for (auto& [key, intervals] : edges) {
    const bool along_x = key.first;
    const double line = static_cast<double>(key.second) * 1e-6;
    std::sort(intervals.begin(), intervals.end());
    for (std::size_t k = 0; k < intervals.size();) {
      auto [from, to] = intervals[k];
      for (++k; k < intervals.size() && intervals[k].first < to + kEpsilon_m; ++k) {
        to = std::max(to, intervals[k].second);
      }
      std::vector<Opening> openings;
      const auto cut = [&](const auto& hole) {
        if (hole.wall_along_x == along_x && is_same(hole.line_m, line) &&
            hole.opening.center_m > from && hole.opening.center_m < to) {
          openings.push_back(hole.opening);
        }
      };
      std::for_each(doorways_.begin(), doorways_.end(), cut);
      std::for_each(windows_.begin(), windows_.end(), cut);
      append_wall({along_x, line, from - 0.5 * kWall_m, to + 0.5 * kWall_m, floor_m_, height_m_,
                   kWall_m, std::move(openings)},
                  albedo, solids);
    }
  }
}

const FloorPlan::Doorway& FloorPlan::doorway(int a, int b) const {
  return *std::find_if(doorways_.begin(), doorways_.end(), [&](const Doorway& d) {
    return (d.a == a && d.b == b) || (d.a == b && d.b == a);
  });
}

void FloorPlan::cross(int room, bool is_dead_end, RandomStream* random, PathWriter* path) const {
  const Area& area = areas_[static_cast<std::size_t>(room)];
  const double size_x = area.max_x - area.min_x;
  const double size_y = area.max_y - area.min_y;
  const double x = 0.5 * (area.min_x + area.max_x);
  const double y = 0.5 * (area.min_y + area.max_y);
  const double pause_s = random->uniform() < 0.4 ? random->uniform(0.5, 1.5) : 0.0;
  if (std::min(size_x, size_y) < kNarrow_m) return;
  if (size_x * size_y > kHall_m2 || is_dead_end) {
    const double side = random->uniform() < 0.5 ? -1.0 : 1.0;
    path->around(x + 0.16 * size_x, y + side * 0.14 * size_y, pause_s, 0.06 * size_x);
    path->around(x - 0.16 * size_x, y + side * 0.14 * size_y, 0.0, 0.06 * size_x);
  } else {
    path->around(x, y, pause_s, 0.3);
  }
}

void FloorPlan::walk(std::span<const int> tour, RandomStream* random, PathWriter* path) const {
  path->set_floor(floor_m_);
  for (std::size_t k = 1; k < tour.size(); ++k) {
    const Doorway& door = doorway(tour[k - 1], tour[k]);
    const Area& next = areas_[static_cast<std::size_t>(tour[k])];
    const double inside =
        door.wall_along_x ? 0.5 * (next.min_y + next.max_y) : 0.5 * (next.min_x + next.max_x);
    const double sign = inside > door.line_m ? 1.0 : -1.0;
    if (door.wall_along_x) {
      path->through_wall_at_y(door.opening.center_m, door.line_m, sign);
    } else {
      path->through_wall_at_x(door.line_m, door.opening.center_m, sign);
    }
    if (k + 1 < tour.size()) cross(tour[k], tour[k + 1] == tour[k - 1], random, path);
  }
}

std::vector<Eigen::Vector3d> FloorPlan::doorway_points() const {
  std::vector<Eigen::Vector3d> points;
  for (const Doorway& door : doorways_) {
    for (double offset = -1.0; offset < 1.05; offset += 0.1) {
      const double across = door.line_m + offset;
      const double along = door.opening.center_m;
      points.emplace_back(door.wall_along_x ? along : across, door.wall_along_x ? across : along,
                          floor_m_ + 1.0);
    }
  }
  return points;
}

std::vector<Room> FloorPlan::rooms(int first_id) const {
  constexpr double kHalf = 0.5 * kWall_m;
  std::vector<Room> rooms;
  for (const Area& area : areas_) {
    rooms.push_back({first_id + static_cast<int>(rooms.size()),
                     area.name,
                     storey_,
                     {area.min_x + kHalf, area.min_y + kHalf, floor_m_},
                     {area.max_x - kHalf, area.max_y - kHalf, floor_m_ + height_m_}});
  }
  return rooms;
}

BoxSolid FloorPlan::slab(double bottom_m, double top_m, float albedo) const {
  constexpr double kHalf = 0.5 * kWall_m;
  const Area all = outline();
  return BoxSolid::from_corners_m({all.min_x - kHalf, all.min_y - kHalf, bottom_m},
                                  {all.max_x + kHalf, all.max_y + kHalf, top_m}, albedo);
}

void furnish_rooms(std::span<const Eigen::Vector3d> doorway_points,
                   const std::function<std::vector<Piece>(const Room&)>& pieces_for,
                   RandomStream* random, World* world) {
  constexpr double kClearance_m = 0.42;
  std::vector<Eigen::Vector3d> keep_free = densify(world->path);
  keep_free.insert(keep_free.end(), doorway_points.begin(), doorway_points.end());
  for (const Room& room : world->rooms) {
    furnish(room, pieces_for(room), keep_free, kClearance_m, random, &world->solids);
  }
}

std::vector<Piece> draw_pieces(const Room& room, std::span<const Piece> kinds, int most,
                               RandomStream* random) {
  const Eigen::Vector3d size = room.max_W - room.min_W;
  const double count = size.x() * size.y() / 4.0 * random->uniform(1.0, 2.0);
  std::vector<Piece> pieces;
  for (int k = 0; k < std::min(most, static_cast<int>(count)); ++k) {
    pieces.push_back(kinds[random->below(kinds.size())]);
  }
  return pieces;
}

}  // namespace cloister
