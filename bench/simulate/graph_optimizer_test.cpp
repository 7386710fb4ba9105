#include "bench/simulate/graph_optimizer.hpp"

#include <doctest/doctest.h>

#include "bench/simulate/random_stream.hpp"

namespace cloister {
namespace {

Vector6d random_tangent(RandomStream* random, double metres, double radians) {
  Vector6d v;
  for (int k = 0; k < 6; ++k) v[k] = (k < 3 ? metres : radians) * random->normal();
  return v;
}

std::vector<Pose> make_circle(std::size_t count, RandomStream* random) {
  std::vector<Pose> poses = {Pose::Identity()};
  while (poses.size() < count) {
    Vector6d step = random_tangent(random, 0.3, 0.15);
    step[0] += 2.0;
    step[5] += 2.0 * 3.14159 / static_cast<double>(count);
    poses.push_back(poses.back() * pose_from_tangent(step));
  }
  return poses;
}

TEST_CASE("a loop of exact measurements is recovered from a bad start") {
  RandomStream random(7, 1);
  const std::vector<Pose> truth = make_circle(40, &random);
  std::vector<RelativeMeasurement> measurements;
  const auto measure = [&](std::size_t from, std::size_t to) {
    Information information = Information::Identity();
    information.diagonal() << 100, 90, 400, 3000, 2000, 1000;
    measurements.push_back({from, to, truth[from].inverse() * truth[to], information});
  };
  for (std::size_t k = 1; k < truth.size(); ++k) measure(k - 1, k);
  measure(0, 39);
  measure(30, 5);
  std::vector<Pose> poses = truth;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    poses[k] = poses[k] * pose_from_tangent(random_tangent(&random, 0.5, 0.2));
  }

  const int iterations = optimize_graph(measurements, &poses);

  CHECK(iterations > 0);
  CHECK(iterations < 12);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    CHECK(tangent_from_pose(truth[k].inverse() * poses[k]).norm() < 1e-7);
  }
}

TEST_CASE("a closed loop pulls drifted poses towards the truth and lowers the error") {
  RandomStream random(11, 1);
  const std::vector<Pose> truth = make_circle(60, &random);
  std::vector<RelativeMeasurement> measurements;
  std::vector<Pose> poses = {truth[0]};
  for (std::size_t k = 1; k < truth.size(); ++k) {
    const Pose T_from_to =
        truth[k - 1].inverse() * truth[k] * pose_from_tangent(random_tangent(&random, 0.03, 0.01));
    measurements.push_back({k - 1, k, T_from_to, Information::Identity() * 1000.0});
    poses.push_back(poses.back() * T_from_to);
  }
  measurements.push_back({0, 59, truth[0].inverse() * truth[59], Information::Identity() * 1e6});
  const double drift_before = (poses[59].translation() - truth[59].translation()).norm();
  const double error_before = graph_error(poses, measurements);

  REQUIRE(optimize_graph(measurements, &poses) > 0);

  CHECK((poses[59].translation() - truth[59].translation()).norm() < 0.1 * drift_before);
  CHECK(graph_error(poses, measurements) < error_before);
}

TEST_CASE("at the optimum no single pose can be moved to a lower error") {
  RandomStream random(13, 1);
  const std::vector<Pose> truth = make_circle(12, &random);
  std::vector<RelativeMeasurement> measurements;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const std::size_t next = (k + 1) % truth.size();
    measurements.push_back(
        {k, next,
         truth[k].inverse() * truth[next] * pose_from_tangent(random_tangent(&random, 0.05, 0.05)),
         Information::Identity() * 50.0});
  }
  std::vector<Pose> poses = truth;
  REQUIRE(optimize_graph(measurements, &poses) > 0);
  const double least = graph_error(poses, measurements);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    for (int axis = 0; axis < 6; ++axis) {
      for (const double sign : {-1e-4, 1e-4}) {
        std::vector<Pose> moved = poses;
        Vector6d step = Vector6d::Zero();
        step[axis] = sign;
        moved[k] = moved[k] * pose_from_tangent(step);
        CHECK(graph_error(moved, measurements) > least);
      }
    }
  }
}

TEST_CASE("a graph whose pose hangs in the air is declined") {
  std::vector<Pose> poses(3, Pose::Identity());
  const std::vector<RelativeMeasurement> measurements = {
      {0, 1, Pose::Identity(), Information::Identity()}};
  CHECK(optimize_graph(measurements, &poses) == -1);
}

}  // namespace
}  // namespace cloister
