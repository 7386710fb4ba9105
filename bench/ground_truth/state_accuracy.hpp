#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "bench/ground_truth/truth.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "mapping/core/pose.hpp"

namespace cloister {

/// What a map says about a point.
enum class PointState { kUnknown, kFree, kOccupied };

/// A point of the world and what is truly there.
struct TruePoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  bool is_solid = false;
};

/// How a map's answers compare with the truth.
struct StateAccuracy {
  std::size_t points = 0;
  std::size_t known_free = 0;
  std::size_t known_free_right = 0;
  std::size_t known_occupied = 0;
  std::size_t known_occupied_wrong = 0;
  std::size_t unknown = 0;
  std::size_t truly_free = 0;
};

/// Draws points that are clear of every surface, uniformly from the observed part of the world: its rooms, with the
/// slabs above and below; without rooms, whatever is within 10 m of the way (3 m up and down).
/// Fewer than `count` come back when the region hardly has such points.
[[nodiscard]] std::vector<TruePoint> sample_points(const GroundTruth& truth,
                                                   const RayScene& scene_W, std::size_t count,
                                                   double clearance_m, std::uint64_t seed);

/// The points in M as the text of a POINTS.csv.
[[nodiscard]] std::string format_points(const std::vector<TruePoint>& points, const Pose& T_W_M);

/// Reads a STATES.csv that answers `count` points in order. Errors: kInput with file and line
[[nodiscard]] Result<std::vector<PointState>> read_states(const std::filesystem::path& file,
                                                          std::size_t count);

/// Compares; as many states as points.
[[nodiscard]] StateAccuracy compare_states(const std::vector<TruePoint>& points,
                                           const std::vector<PointState>& states);

}  // namespace cloister
