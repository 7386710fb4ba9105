#include "bench/simulate/odometry.hpp"

#include <cmath>

#include "bench/simulate/random_stream.hpp"

namespace cloister {

Trajectory corrupt(const Trajectory& truth, const DriftConfig& drift, std::uint64_t seed) {
  constexpr double kCorrelation_m =
      0.5;  // errors keep their sign for about half a metre: odometry is smooth
  RandomStream random = random_stream(seed, Purpose::kOdometry);
  const double factor = drift.factor();
  const double scale = 1.0 + factor * drift.scale * random.normal();

  Trajectory odometry = truth;
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();  // drift per metre, coloured
  double yaw_slip = 0.0;
  double yaw = 0.0;
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();
  const Pose T_W_start = truth.poses.front();
  for (std::size_t k = 0; k < truth.poses.size(); ++k) {
    if (k > 0) {
      const Eigen::Vector3d step_W =
          truth.poses[k].translation() - truth.poses[k - 1].translation();
      const double length = step_W.norm();
      // First-order Gauss-Markov over the distance; its integral grows like a random walk of the
      // given strength.
      const double decay = std::exp(-length / kCorrelation_m);
      const double kick = std::sqrt((1.0 - decay * decay) / (2.0 * kCorrelation_m));
      const double walk = factor * drift.walk_m_per_sqrt_m * kick;
      const double climb = factor * drift.climb_m_per_sqrt_m * kick;
      slip = decay * slip + Eigen::Vector3d(walk * random.normal(), walk * random.normal(),
                                            climb * random.normal());
      yaw_slip = decay * yaw_slip + factor * drift.yaw_rad_per_sqrt_m * kick * random.normal();
      yaw += yaw_slip * length;
      const double tilt_kick = factor * drift.tilt_rad * std::sqrt(2.0 * 0.01);
      tilt = 0.99 * tilt + tilt_kick * Eigen::Vector2d(random.normal(), random.normal());
      t += scale * (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * step_W) + slip * length;
    }
    const Eigen::Quaterniond q = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                 Eigen::Quaterniond(truth.poses[k].linear()) *
                                 Eigen::AngleAxisd(tilt.x(), Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(tilt.y(), Eigen::Vector3d::UnitY());
    odometry.poses[k] = make_pose(t, q);
  }
  const Pose T_O_drift =
      make_pose(Eigen::Vector3d::Zero(), Eigen::Quaterniond(T_W_start.linear())).inverse();
  for (Pose& pose : odometry.poses) pose = T_O_drift * pose;
  return odometry;
}

}  // namespace cloister
