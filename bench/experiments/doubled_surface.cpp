#include "bench/experiments/doubled_surface.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "bench/ground_truth/mesh_accuracy.hpp"

namespace cloister {

namespace {

constexpr float kNearestGap_m = 0.05F;
constexpr float kFurthestGap_m = 0.50F;
constexpr float kFarGap_m = 0.10F;
constexpr float kParallelCosine = 0.9F;
constexpr float kReach_m = 1.0F;  // distances from the truth are cut off there

Eigen::Vector3f normal_of(const TriangleMesh& mesh, std::size_t triangle) {
  const Eigen::Vector3f a = mesh.corner(triangle, 0);
  return (mesh.corner(triangle, 1) - a).cross(mesh.corner(triangle, 2) - a).stableNormalized();
}

/// How far away the next sheet is that looks along `normal`, from `p` into `direction`.
std::optional<float> find_sheet(const TriangleMesh& mesh, const RayScene& scene,
                                const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                                const Eigen::Vector3f& direction) {
  constexpr float kStep_m = 1e-3F;  // past a sheet that looks another way
  float at_m = kNearestGap_m;
  while (at_m < kFurthestGap_m) {
    RayHit hit;
    scene.cast(p + at_m * direction, {&direction, 1}, kFurthestGap_m - at_m, {&hit, 1});
    if (hit.triangle == RayHit::kNone) return std::nullopt;
    at_m += hit.distance_m;
    if (normal_of(mesh, hit.triangle).dot(normal) > kParallelCosine) return at_m;
    at_m += kStep_m;
  }
  return std::nullopt;
}

bool is_one_surface(const RayScene& truth, const LocalAlignment& alignment,
                    const Eigen::Vector3f& a_M, const Eigen::Vector3f& b_M, float gap_m) {
  const auto distance_m = [&](const Eigen::Vector3f& p_M) {
    return truth.distance(alignment.to_world(p_M.cast<double>()).cast<float>(), kReach_m);
  };
  const float a_m = distance_m(a_M);
  const float b_m = distance_m(b_M);
  return std::max(a_m, b_m) > std::max(0.05F, 0.45F * gap_m) && std::min(a_m, b_m) < kFurthestGap_m;
}

}  // namespace

Result<DoubledSurface> find_doubled_surface(const TriangleMesh& mesh_M,
                                            const LocalAlignment& alignment,
                                            const RayScene& truth_W, std::size_t samples,
                                            std::uint64_t seed) {
  const auto scene = RayScene::build(mesh_M);
  if (!scene) return tl::unexpected(scene.error());
  std::vector<std::size_t> triangles;
  const auto points = sample_surface(mesh_M, samples, seed, &triangles);
  DoubledSurface result;
  result.samples = points.size();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3f p = points[k].cast<float>();
    const Eigen::Vector3f normal = normal_of(mesh_M, triangles[k]);
    float widest_m = 0.0F;
    for (const float sign : {1.0F, -1.0F}) {
      const Eigen::Vector3f direction = sign * normal;
      const auto gap_m = find_sheet(mesh_M, *scene, p, normal, direction);
      if (!gap_m || !is_one_surface(truth_W, alignment, p, p + *gap_m * direction, *gap_m)) continue;
      widest_m = std::max(widest_m, *gap_m);
    }
    result.doubled += widest_m > 0.0F ? 1 : 0;
    result.far += widest_m > kFarGap_m ? 1 : 0;
  }
  return result;
}

}  // namespace cloister
