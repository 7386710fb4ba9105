#include "bench/simulate/graph_optimizer.hpp"

#include <cmath>

#include <Eigen/SparseCholesky>

namespace cloister {

namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Inverse of the right Jacobian of SO(3): d log(R exp(d)) / d d (Sola et al. 2018, equation 144).
Eigen::Matrix3d inverse_right_jacobian(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  const Eigen::Matrix3d W = skew(rotation);
  const double c = angle < 1e-4 ? 1.0 / 12.0
                                : 1.0 / (angle * angle) -
                                      (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  return Eigen::Matrix3d::Identity() + 0.5 * W + c * W * W;
}

/// Error of a measurement and its derivatives with respect to both poses' perturbations.
struct Linearized {
  Vector6d error;
  Information J_from;
  Information J_to;
};

Linearized linearize(const RelativeMeasurement& m, const std::vector<Pose>& poses) {
  const Pose T_from_to = poses[m.from].inverse() * poses[m.to];
  const Pose difference = m.T_from_to.inverse() * T_from_to;
  Linearized out;
  out.error = tangent_from_pose(difference);
  const Eigen::Matrix3d R_m = m.T_from_to.linear().transpose();
  const Eigen::Matrix3d Jr = inverse_right_jacobian(out.error.tail<3>());
  // Translation error: R_m (t_from_to - t_m); rotation error: log(R_m R_from_to).
  out.J_to.setZero();
  out.J_to.topLeftCorner<3, 3>() = difference.linear();
  out.J_to.bottomRightCorner<3, 3>() = Jr;
  out.J_from.setZero();
  out.J_from.topLeftCorner<3, 3>() = -R_m;
  out.J_from.topRightCorner<3, 3>() = R_m * skew(T_from_to.translation());
  out.J_from.bottomRightCorner<3, 3>() = -Jr * T_from_to.linear().transpose();
  return out;
}

}  // namespace

Pose pose_from_tangent(const Vector6d& tangent) {
  Pose pose = Pose::Identity();
  const double angle = tangent.tail<3>().norm();
  if (angle > 0.0)
    pose.linear() = Eigen::AngleAxisd(angle, tangent.tail<3>() / angle).toRotationMatrix();
  pose.translation() = tangent.head<3>();
  return pose;
}

Vector6d tangent_from_pose(const Pose& pose) {
  const Eigen::AngleAxisd rotation(pose.linear());
  Vector6d tangent;
  tangent << pose.translation(), rotation.angle() * rotation.axis();
  return tangent;
}

double graph_error(const std::vector<Pose>& poses,
                   const std::vector<RelativeMeasurement>& measurements) {
  double sum = 0.0;
  for (const RelativeMeasurement& m : measurements) {
    const Vector6d e =
        tangent_from_pose(m.T_from_to.inverse() * poses[m.from].inverse() * poses[m.to]);
    sum += e.dot(m.information * e);
  }
  return sum;
}

int optimize_graph(const std::vector<RelativeMeasurement>& measurements, std::vector<Pose>* poses,
                   int max_iterations) {
  if (poses->size() < 2) return 0;
  const auto unknowns = static_cast<Eigen::Index>(6 * (poses->size() - 1));
  std::vector<Pose> trial = *poses;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  std::vector<Eigen::Triplet<double>> entries;
  for (int iteration = 1; iteration <= max_iterations; ++iteration) {
    entries.clear();
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns);
    // The first pose is held: its rows and columns are never made.
    const auto add_block = [&](std::size_t row, std::size_t column, const Information& block) {
      if (row == 0 || column == 0 || row < column) return;
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) {
          entries.emplace_back(static_cast<int>(6 * (row - 1)) + r,
                               static_cast<int>(6 * (column - 1)) + c, block(r, c));
        }
      }
    };
    for (const RelativeMeasurement& m : measurements) {
      const Linearized l = linearize(m, trial);
      const Information from_weighted = l.J_from.transpose() * m.information;
      const Information to_weighted = l.J_to.transpose() * m.information;
      add_block(m.from, m.from, from_weighted * l.J_from);
      add_block(m.to, m.to, to_weighted * l.J_to);
      add_block(m.from, m.to, from_weighted * l.J_to);
      add_block(m.to, m.from, to_weighted * l.J_from);
      if (m.from > 0)
        gradient.segment<6>(static_cast<Eigen::Index>(6 * (m.from - 1))) += from_weighted * l.error;
      if (m.to > 0)
        gradient.segment<6>(static_cast<Eigen::Index>(6 * (m.to - 1))) += to_weighted * l.error;
    }
    Eigen::SparseMatrix<double> hessian(unknowns, unknowns);
    hessian.setFromTriplets(entries.begin(), entries.end());
    if (iteration == 1) solver.analyzePattern(hessian);
    solver.factorize(hessian);
    if (solver.info() != Eigen::Success) return -1;
    const Eigen::VectorXd step = solver.solve(-gradient);
    if (!step.allFinite()) return -1;
    for (std::size_t k = 1; k < trial.size(); ++k) {
      const Pose moved =
          trial[k] * pose_from_tangent(step.segment<6>(static_cast<Eigen::Index>(6 * (k - 1))));
      trial[k] = make_pose(moved.translation(), Eigen::Quaterniond(moved.linear()));
    }
    *poses = trial;
    if (step.lpNorm<Eigen::Infinity>() < 1e-9) return iteration;
  }
  return max_iterations;
}

}  // namespace cloister
