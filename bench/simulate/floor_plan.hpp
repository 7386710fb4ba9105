#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/building.hpp"
#include "bench/simulate/furniture.hpp"
#include "bench/simulate/path_writer.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// One storey cut into rectangular rooms: its walls stand on the rooms' outlines, doorways join
/// neighbours, and a tour is a sequence of rooms.
class FloorPlan {
 public:
  /// @param floor_m z of the floor
  FloorPlan(int storey, double floor_m, double height_m)
      : storey_(storey), floor_m_(floor_m), height_m_(height_m) {}

  /// A room between the middle planes of its walls. @return its place in the plan
  int add_room(std::string name, double min_x, double min_y, double max_x, double max_y);

  /// A doorway somewhere in the wall two rooms share (at least half a metre from its ends).
  void connect(int a, int b, RandomStream* random, double width_m = 0.9);
  /// A doorway around a given middle, along the wall two rooms share.
  void connect_at(int a, int b, double center_m, double width_m = 0.9);

  /// Windows for a share of the rooms' outer walls.
  void add_windows(double share, RandomStream* random);

  /// Appends the walls; to be called when all doorways and windows are known.
  void append_walls(float albedo, std::vector<BoxSolid>* solids) const;

  /// Walks from the first room of the tour, where the path must stand already, into its last one.
  /// Consecutive rooms are connected. Rooms in between are crossed by their middle, halls and dead
  /// ends by two places, narrow ones straight.
  void walk(std::span<const int> tour, RandomStream* random, PathWriter* path) const;

  /// The ways through the doorways as points, a metre to both sides.
  [[nodiscard]] std::vector<Eigen::Vector3d> doorway_points() const;

  /// The rooms inside their walls, numbered from `first_id`.
  [[nodiscard]] std::vector<Room> rooms(int first_id) const;

  /// A slab under or over the whole plan, walls included.
  [[nodiscard]] BoxSolid slab(double bottom_m, double top_m, float albedo) const;

 private:
  struct Area {
    std::string name;
    double min_x, min_y, max_x, max_y;
  };
  struct Doorway {
    int a, b;
    bool wall_along_x;  ///< in a wall that runs along x at y = line_m
    double line_m;
    Opening opening;
  };
  struct Window {
    bool wall_along_x;
    double line_m;
    Opening opening;
  };
  struct SharedWall {
    bool along_x;
    double line_m, from_m, to_m;
  };

  [[nodiscard]] SharedWall shared_wall(int a, int b) const;
  [[nodiscard]] const Doorway& doorway(int a, int b) const;
  [[nodiscard]] Area outline() const;
  void cross(int room, bool is_dead_end, RandomStream* random, PathWriter* path) const;

  int storey_;
  double floor_m_;
  double height_m_;
  std::vector<Area> areas_;
  std::vector<Doorway> doorways_;
  std::vector<Window> windows_;
};

/// Furnishes rooms of a world whose path is known, so that all ways stay free.
/// @param doorway_points of the plans that the rooms come from
/// @param pieces_for what stands in a room
void furnish_rooms(std::span<const Eigen::Vector3d> doorway_points,
                   const std::function<std::vector<Piece>(const Room&)>& pieces_for,
                   RandomStream* random, World* world);

/// A room's furniture drawn from what its kind has: one to two pieces per four square metres, at
/// most `most`.
[[nodiscard]] std::vector<Piece> draw_pieces(const Room& room, std::span<const Piece> kinds,
                                             int most, RandomStream* random);

}  // namespace cloister
