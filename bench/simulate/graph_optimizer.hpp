#pragma once

#include <vector>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"

namespace cloister {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Information = Eigen::Matrix<double, 6, 6>;

/// A measured relative pose between two poses of a graph, by position; information in (translation,
/// rotation) order.
struct RelativeMeasurement {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose T_from_to = Pose::Identity();
  Information information = Information::Identity();
};

/// Exponential of (translation, rotation vector): the rotation's exponential, the translation taken
/// as it is.
[[nodiscard]] Pose pose_from_tangent(const Vector6d& tangent);
/// Its inverse.
[[nodiscard]] Vector6d tangent_from_pose(const Pose& pose);

/// Sum over the measurements of e' Omega e with e the tangent of inv(T_from_to) inv(T_from) T_to.
[[nodiscard]] double graph_error(const std::vector<Pose>& poses,
                                 const std::vector<RelativeMeasurement>& measurements);

/// Moves all poses but the first to the least sum of squared errors: Gauss-Newton on perturbations
/// from the right, T <- T exp(d), sparse Cholesky in every step. Measurements must join every pose
/// to the first.
/// @return iterations used, or -1 when the system could not be solved (poses are left as they were
/// then)
int optimize_graph(const std::vector<RelativeMeasurement>& measurements, std::vector<Pose>* poses,
                   int max_iterations = 20);

}  // namespace cloister
