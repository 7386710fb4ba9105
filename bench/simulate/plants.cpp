#include "bench/simulate/plants.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace cloister {

namespace {

constexpr float kBark = 0.3F;
constexpr float kLeaf = 0.55F;

Eigen::Vector3d random_direction(RandomStream* random) {
  return Eigen::Vector3d(random->normal(), random->normal(), random->normal()).normalized();
}

/// A flat tetrahedron, seen from above a rhombus: some leaves that hang together.
void append_leaf(const Eigen::Vector3d& center, RandomStream* random, TriangleMesh* mesh,
                 std::vector<ConvexPart>* parts) {
  constexpr double kThickness = 0.015;
  const double length = random->uniform(0.18, 0.32);
  const double width = random->uniform(0.14, 0.24);
  const Eigen::Vector3d normal = random_direction(random);
  const Eigen::Vector3d u =
      Eigen::AngleAxisd(random->uniform(0.0, 2.0 * std::numbers::pi), normal) *
      normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  const auto corner = [&](double along_u, double along_v, double along_n) {
    return Eigen::Vector3f((center + along_u * u + along_v * v + along_n * normal).cast<float>());
  };
  parts->push_back(append_tetrahedron(
      {corner(-0.5 * length, 0.0, 0.0), corner(0.5 * length, 0.0, 0.0),
       corner(0.0, -0.5 * width, kThickness), corner(0.0, 0.5 * width, kThickness)},
      kLeaf, mesh));
}

}  // namespace

void append_tree(const Eigen::Vector3d& foot_W, RandomStream* random, TriangleMesh* mesh,
                 std::vector<ConvexPart>* parts) {
  constexpr int kClusters = 60;
  constexpr int kLeavesPerCluster = 40;
  constexpr double kClusterSigma = 0.33;
  constexpr double kLowest = 2.4;
  constexpr double kRoots = 0.4;
  const double crown_radius = random->uniform(2.1, 3.4);
  const double crown_half_height = random->uniform(2.0, 3.4);
  const double trunk_radius = random->uniform(0.12, 0.28);
  const double crown_middle = random->uniform(2.6, 3.4) + crown_half_height;
  const Eigen::Vector3d lean(random->uniform(-0.25, 0.25), random->uniform(-0.25, 0.25), 0.0);
  const auto on_trunk = [&](double z) {
    return Eigen::Vector3d(foot_W + Eigen::Vector3d(0, 0, z) + lean * (z / crown_middle));
  };
  const auto rod = [&](const Eigen::Vector3d& a, double ra, const Eigen::Vector3d& b, double rb,
                       int sides) {
    parts->push_back(append_rod(a.cast<float>(), static_cast<float>(ra), b.cast<float>(),
                                static_cast<float>(rb), sides, kBark, mesh));
  };
  rod(on_trunk(-kRoots), 1.15 * trunk_radius, on_trunk(crown_middle), 0.45 * trunk_radius, 8);

  for (int cluster = 0; cluster < kClusters; ++cluster) {
    // In the outer part of the crown, where the light is.
    const Eigen::Vector3d place = random_direction(random) * std::cbrt(random->uniform(0.15, 1.0));
    Eigen::Vector3d middle =
        on_trunk(crown_middle) +
        place.cwiseProduct(Eigen::Vector3d(crown_radius, crown_radius, crown_half_height));
    middle.z() = std::max(middle.z(), foot_W.z() + kLowest + 0.3);
    if (cluster % 5 == 0) {
      const double at =
          std::clamp(middle.z() - foot_W.z() - random->uniform(0.8, 1.8), 1.9, crown_middle - 0.2);
      rod(on_trunk(at), 0.35 * trunk_radius, middle, 0.02, 4);
    }
    for (int leaf = 0; leaf < kLeavesPerCluster; ++leaf) {
      Eigen::Vector3d center =
          middle +
          kClusterSigma * Eigen::Vector3d(random->normal(), random->normal(), random->normal());
      center.z() = std::max(center.z(), foot_W.z() + kLowest + random->uniform(0.1, 0.3));
      append_leaf(center, random, mesh, parts);
    }
  }
}

void append_hedge(const Eigen::Vector3d& from_W, const Eigen::Vector3d& to_W, double width_m,
                  double height_m, RandomStream* random, TriangleMesh* mesh,
                  std::vector<ConvexPart>* parts) {
  constexpr double kLeavesPerCubicMetre = 90.0;
  const Eigen::Vector3d along = to_W - from_W;
  const Eigen::Vector3d across = Eigen::Vector3d(-along.y(), along.x(), 0.0).normalized();
  const int leaves = static_cast<int>(kLeavesPerCubicMetre * along.norm() * width_m * height_m);
  for (int k = 0; k < leaves; ++k) {
    const double offset = 0.25 * width_m * std::clamp(random->normal(), -2.0, 2.0);
    append_leaf(from_W + random->uniform() * along + offset * across +
                    Eigen::Vector3d(0, 0, random->uniform(0.0, height_m)),
                random, mesh, parts);
  }
}

}  // namespace cloister
