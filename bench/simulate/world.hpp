#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "bench/simulate/box_solid.hpp"
#include "bench/simulate/convex_part.hpp"
#include "bench/simulate/height_field.hpp"
#include "bench/simulate/triangle_mesh.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// A named part of the world, for judging where submaps begin and end.
struct Room {
  int id = 0;
  std::string name;
  int storey = 0;
  Eigen::Vector3d min_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d max_W = Eigen::Vector3d::Zero();

  /// True at least `margin_m` inside the room's walls, floor and ceiling.
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_W, double margin_m = 0.0) const {
    return ((p_W - min_W).array() >= margin_m).all() && ((max_W - p_W).array() >= margin_m).all();
  }
};

/// A place the sensor passes.
struct Waypoint {
  Eigen::Vector3d position_W = Eigen::Vector3d::Zero();  ///< of the sensor, not of the feet
  double pause_s = 0.0;                                  ///< how long the walk stops there
};

/// What there is to see, and a way through it. W is the world frame, z up, metres.
///
/// The mesh of a built-in world is the surface of its solids' union, the convex parts and the
/// ground, one after the other: what stands in the ground or grows into a wall is not cut off.
struct World {
  std::string name;
  std::string sensor = "os0-64";  ///< carried unless another one is asked for
  TriangleMesh mesh;
  std::vector<BoxSolid> solids;       ///< empty for a world read from a file
  std::vector<ConvexPart> parts;      ///< ranges of the mesh
  std::optional<HeightField> ground;  ///< none where slabs are the ground
  std::vector<Room> rooms;            ///< empty when the world has none
  std::vector<Waypoint> path;

  /// Inside one of the solids or parts, or below the ground. O(solids + parts)
  [[nodiscard]] bool is_solid(const Eigen::Vector3d& p_W) const;
};

/// Names of the built-in worlds, for the help text.
[[nodiscard]] std::vector<std::string> world_names();

/// Builds a built-in world by its name. Errors: kInput for a name it does not know.
[[nodiscard]] Result<World> make_world(const std::string& name, std::uint64_t seed);

}  // namespace cloister
