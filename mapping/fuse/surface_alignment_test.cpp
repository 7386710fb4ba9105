#include "mapping/fuse/surface_alignment.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/fuse/walls_for_tests.hpp"

namespace cloister {
namespace {

constexpr double kVoxelM = 0.065;
constexpr double kSigmaM = 0.2;

Pose pose(const Eigen::Vector3d& t, double yaw_degrees) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())
                   .toRotationMatrix();
  T.translation() = t;
  return T;
}

struct Fixture {
  VoxelStore store{6000, 200};
  VoxelPools pools{store};
  Fixture() { pools.take_all(); }

  Volume view(const std::vector<Wall>& walls, const Pose& T_W_S, double half_length_m = 3) {
    return view_of_walls(walls, T_W_S, pools, kVoxelM, half_length_m);
  }
};

/// How far a pose moves places in reach of a room otherwise than it should.
double error_m(const Pose& T, const Pose& truth) {
  double most_m = 0;
  for (const double x : {-2.5, 2.5}) {
    for (const double y : {-2.0, 2.0}) {
      const Eigen::Vector3d p(x, y, 1);
      most_m = std::max(most_m, (T * p - truth * p).norm());
    }
  }
  return most_m;
}

TEST_CASE("the surfaces of a room tell where the graph has two submaps wrong") {
  Fixture f;
  const Pose T_W_a = pose({0.31, -0.22, 0.04}, 3), T_W_b = pose({-0.4, 0.15, -0.11}, 31);
  const Volume a = f.view(tilted_room(), T_W_a), b = f.view(tilted_room(), T_W_b);
  const Pose truth = T_W_b.inverse() * T_W_a;
  for (const Pose& wrong : {pose({0.18, 0, 0}, 0), pose({-0.1, 0.12, 0.06}, 0),
                            pose({0.05, -0.1, 0}, 1.5), pose({0, 0, 0.15}, -1)}) {
    const Pose graph = truth * wrong;
    CAPTURE(error_m(graph, truth));
    REQUIRE(error_m(graph, truth) > 0.1);
    const SurfaceAlignment aligned = align_surfaces(f.store, a, b, graph, kSigmaM, kVoxelM);
    CHECK(aligned.shift_m > 0.05);
    CHECK(error_m(aligned.T_b_a, truth) < 0.03);
    // The same question from the other side.
    const SurfaceAlignment back =
        align_surfaces(f.store, b, a, graph.inverse(), kSigmaM, kVoxelM);
    CHECK(error_m(back.T_b_a.inverse(), truth) < 0.03);
  }
}

TEST_CASE("a graph that is right is left alone, to the bit") {
  Fixture f;
  const Pose T_W_a = pose({0.3, -0.2, 0}, 5), T_W_b = pose({-0.4, 0.1, 0}, 40);
  const Volume a = f.view(tilted_room(), T_W_a), b = f.view(tilted_room(), T_W_b);
  const Pose graph = T_W_b.inverse() * T_W_a;
  const SurfaceAlignment aligned = align_surfaces(f.store, a, b, graph, kSigmaM, kVoxelM);
  CHECK(aligned.shift_m == 0);
  CHECK(aligned.T_b_a.matrix() == graph.matrix());
}

TEST_CASE("walls that have grown thick to the back are laid on each other by their fronts") {
  Fixture f;
  // All on one side: otherwise the wall across would hold against it.
  const std::vector<Wall> all = tilted_room(), corner{all[0], all[2], all[5]};
  const Volume thin = f.view(corner, Pose::Identity());
  const Volume thick = view_of_walls(corner, Pose::Identity(), f.pools, kVoxelM, 3, 3 * kVoxelM);
  CHECK(align_surfaces(f.store, thin, thick, Pose::Identity(), kSigmaM, kVoxelM).shift_m == 0);
  for (const Eigen::Vector3d& aside : {Eigen::Vector3d{0.02, 0.02, 0}, Eigen::Vector3d{0.12, 0.08, 0.05}}) {
    const SurfaceAlignment aligned =
        align_surfaces(f.store, thin, thick, pose(aside, 0), kSigmaM, kVoxelM);
    CHECK(error_m(aligned.T_b_a, Pose::Identity()) < 0.02);
  }
}

TEST_CASE("where nothing tells how far along a corridor one is, the graph's word stands") {
  Fixture f;
  const Pose T_W_a = pose({0, 0.02, 0.01}, 10), T_W_b = pose({0, -0.03, 0.02}, -7);
  const Volume a = f.view(corridor(), T_W_a), b = f.view(corridor(), T_W_b);
  const Pose truth = T_W_b.inverse() * T_W_a;
  const Pose moved_W = pose({0.15, 0.12, 0}, 0);  // along the corridor, and across
  const Pose graph = T_W_b.inverse() * moved_W * T_W_a;
  const SurfaceAlignment aligned = align_surfaces(f.store, a, b, graph, kSigmaM, kVoxelM);
  const Eigen::Vector3d left_W = T_W_b.linear() * (aligned.T_b_a.translation() - truth.translation());
  CHECK(std::abs(left_W.y()) < 0.03);
  CHECK(left_W.x() == doctest::Approx(0.15).epsilon(0.2));
}

TEST_CASE("the answer is never further from the graph's word than that may be wrong") {
  Fixture f;
  const Volume a = f.view(tilted_room(), Pose::Identity()), b = f.view(tilted_room(), Pose::Identity());
  for (const double wrong_m : {0.3, 0.45, 0.6, 0.9}) {
    const Pose graph = pose({wrong_m, 0, 0}, 0);
    const SurfaceAlignment aligned = align_surfaces(f.store, a, b, graph, 0.05, kVoxelM);
    CHECK((aligned.T_b_a.translation() - graph.translation()).norm() <= 0.1);
    CHECK(aligned.shift_m <= 0.1);
  }
}

TEST_CASE("too little surface in common says nothing") {
  Fixture f;
  const Volume a = f.view(tilted_room(), Pose::Identity(), 0.8), b = f.view(tilted_room(), Pose::Identity());
  const Pose graph = pose({0.12, 0, 0}, 0);
  const SurfaceAlignment aligned = align_surfaces(f.store, a, b, graph, kSigmaM, kVoxelM);
  CHECK(aligned.T_b_a.matrix() == graph.matrix());
  const Volume nothing;
  CHECK(align_surfaces(f.store, nothing, b, graph, kSigmaM, kVoxelM).shift_m == 0);
}

}  // namespace
}  // namespace cloister
