#pragma once

#include <cstdint>
#include <vector>

#include "bench/ground_truth/truth.hpp"
#include "bench/simulate/ray_scene.hpp"
#include "mapping/core/pose.hpp"

namespace cloister {

/// Distances from a reconstructed mesh to the true surface, and how much of the true surface it covers.
struct MeshAccuracy {
  std::size_t samples = 0;
  double within_5cm = 0.0;  ///< shares of the samples, 0 to 1
  double within_10cm = 0.0;
  double within_25cm = 0.0;
  double mean_m = 0.0;
  double p95_m = 0.0;
  double max_m = 0.0;          ///< distances are cut off at 5 m
  double complete_10cm = 0.0;  ///< share of the seen true surface that has some mesh within 10 cm
  std::size_t surface_samples = 0;  ///< true surface points that were in sight of the way
};

/// Points spread evenly over a mesh's area. @return `count` points, none for a mesh without area
/// @param triangles where given, filled with the triangle each point lies on
[[nodiscard]] std::vector<Eigen::Vector3d> sample_surface(
    const TriangleMesh& mesh, std::size_t count, std::uint64_t seed,
    std::vector<std::size_t>* triangles = nullptr);

/// Judges a mesh in M against the truth. True surface counts as seen when some place of the way, within 20 m, has a
/// clear line to it; the sensor's field of view is not asked.
/// Errors: those of RayScene::build
[[nodiscard]] Result<MeshAccuracy> compare_mesh(const TriangleMesh& mesh_M, const Pose& T_W_M,
                                                const GroundTruth& truth, const RayScene& scene_W,
                                                std::size_t samples, std::uint64_t seed);

}  // namespace cloister
