#include "bench/ground_truth/mesh_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

constexpr float kCutOff_m = 5.0F;

/// Places of the way, about a metre apart.
std::vector<Eigen::Vector3f> viewpoints_of(const GroundTruth& truth) {
  std::vector<Eigen::Vector3f> views;
  for (const StampedPose& pose : truth.T_W_L) {
    const Eigen::Vector3f p = pose.pose.translation().cast<float>();
    if (views.empty() || (p - views.back()).norm() >= 1.0F) views.push_back(p);
  }
  return views;
}

bool is_seen(const Eigen::Vector3f& p, const std::vector<Eigen::Vector3f>& views,
             const RayScene& scene_W) {
  constexpr float kReach_m = 20.0F;
  constexpr float kInFront_m = 0.005F;  // stop short of the surface itself
  return std::any_of(views.begin(), views.end(), [&](const Eigen::Vector3f& view) {
    const Eigen::Vector3f to_view = view - p;
    const float distance = to_view.norm();
    return distance < kReach_m &&
           scene_W.line_of_sight(view, p + to_view * (kInFront_m / distance));
  });
}

}  // namespace

std::vector<Eigen::Vector3d> sample_surface(const TriangleMesh& mesh, std::size_t count,
                                            std::uint64_t seed,
                                            std::vector<std::size_t>* triangles) {
  std::vector<double> area_up_to(mesh.triangles.size());
  double area = 0.0;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const Eigen::Vector3d a = mesh.corner(k, 0).cast<double>();
    const Eigen::Vector3d e1 = mesh.corner(k, 1).cast<double>() - a;
    const Eigen::Vector3d e2 = mesh.corner(k, 2).cast<double>() - a;
    area += 0.5 * e1.cross(e2).norm();
    area_up_to[k] = area;
  }
  std::vector<Eigen::Vector3d> points;
  if (!(area > 0.0)) return points;
  RandomStream random = random_stream(seed, Purpose::kSampling);
  points.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto at = std::upper_bound(area_up_to.begin(), area_up_to.end(), random.uniform() * area);
    const auto k =
        std::min(static_cast<std::size_t>(at - area_up_to.begin()), area_up_to.size() - 1);
    if (triangles != nullptr) triangles->push_back(k);
    const double root = std::sqrt(random.uniform());
    const double v = random.uniform();
    points.push_back((1.0 - root) * mesh.corner(k, 0).cast<double>() +
                     root * (1.0 - v) * mesh.corner(k, 1).cast<double>() +
                     root * v * mesh.corner(k, 2).cast<double>());
  }
  return points;
}

Result<MeshAccuracy> compare_mesh(const TriangleMesh& mesh_M, const Pose& T_W_M,
                                  const GroundTruth& truth, const RayScene& scene_W,
                                  std::size_t samples, std::uint64_t seed) {
  MeshAccuracy result;
  std::vector<double> distances_m;
  distances_m.reserve(samples);
  for (const Eigen::Vector3d& p_M : sample_surface(mesh_M, samples, seed)) {
    distances_m.push_back(
        static_cast<double>(scene_W.distance((T_W_M * p_M).cast<float>(), kCutOff_m)));
  }
  if (distances_m.empty()) return result;
  std::sort(distances_m.begin(), distances_m.end());
  const auto count = static_cast<double>(distances_m.size());
  const auto share_within = [&](double limit_m) {
    const auto end = std::upper_bound(distances_m.begin(), distances_m.end(), limit_m);
    return static_cast<double>(end - distances_m.begin()) / count;
  };
  result.samples = distances_m.size();
  result.within_5cm = share_within(0.05);
  result.within_10cm = share_within(0.10);
  result.within_25cm = share_within(0.25);
  result.mean_m = std::accumulate(distances_m.begin(), distances_m.end(), 0.0) / count;
  result.p95_m = distances_m[static_cast<std::size_t>(0.95 * (count - 1.0))];
  result.max_m = distances_m.back();

  const auto scene_M = RayScene::build(mesh_M);
  if (!scene_M) return tl::unexpected(scene_M.error());
  const Pose T_M_W = T_W_M.inverse();
  const std::vector<Eigen::Vector3f> views = viewpoints_of(truth);
  std::size_t covered = 0;
  for (const Eigen::Vector3d& p_W : sample_surface(truth.mesh_W, samples / 10, seed + 1)) {
    if (!is_seen(p_W.cast<float>(), views, scene_W)) continue;
    ++result.surface_samples;
    covered += scene_M->distance((T_M_W * p_W).cast<float>(), 0.2F) <= 0.1F ? 1 : 0;
  }
  if (result.surface_samples > 0) {
    result.complete_10cm =
        static_cast<double>(covered) / static_cast<double>(result.surface_samples);
  }
  return result;
}

}  // namespace cloister
