#pragma once

#include <Eigen/Geometry>

namespace cloister {

/// A rigid transform. `T_A_B` is the pose of frame B in frame A and takes coordinates from B to A:
/// `p_A = T_A_B * p_B`. Neighbouring letters cancel: `T_A_C = T_A_B * T_B_C`.
///
/// | letter | frame                                                            |
/// |--------|------------------------------------------------------------------|
/// | M      | map: fixed, z against gravity                                    |
/// | O      | odometry: smooth, drifts                                         |
/// | N      | a pose-graph node (the sensor at the node's stamp)               |
/// | S      | submap; voxels never move inside it                              |
/// | L      | the pose frame of a scan at its stamp: the Ouster sensor frame   |
using Pose = Eigen::Isometry3d;

/// A pose from its translation (metres) and quaternion; the quaternion is normalised.
[[nodiscard]] inline Pose make_pose(const Eigen::Vector3d& t_A_B, const Eigen::Quaterniond& q_A_B) {
  Pose T_A_B = Pose::Identity();
  T_A_B.linear() = q_A_B.normalized().toRotationMatrix();
  T_A_B.translation() = t_A_B;
  return T_A_B;
}

/// The pose between two poses: linear in translation, spherical in rotation.
/// @param fraction 0 gives `T_A_B0`, 1 gives `T_A_B1`
[[nodiscard]] inline Pose interpolate(const Pose& T_A_B0, const Pose& T_A_B1, double fraction) {
  const Eigen::Quaterniond q0(T_A_B0.linear());
  const Eigen::Quaterniond q1(T_A_B1.linear());
  return make_pose((1.0 - fraction) * T_A_B0.translation() + fraction * T_A_B1.translation(),
                   q0.slerp(fraction, q1));
}

/// True when every entry is finite.
[[nodiscard]] inline bool is_finite(const Pose& T_A_B) { return T_A_B.matrix().allFinite(); }

/// True when a pose may be a place: finite, and not as far from the origin as nothing real is. Where an optimiser has
/// diverged, coordinates are no places any more.
[[nodiscard]] inline bool is_place(const Pose& T_A_B) {
  return is_finite(T_A_B) && T_A_B.translation().cwiseAbs().maxCoeff() <= 1e9;
}

}  // namespace cloister
