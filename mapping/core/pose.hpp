#pragma once

#include <cmath>

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

/// The rotation between two, along the shorter arc, at constant speed: to 0.3 microradians where they are close, as
/// samples of one motion are; a chord serves there for the arc.
[[nodiscard]] inline Eigen::Quaterniond interpolate(const Eigen::Quaterniond& q0,
                                                    const Eigen::Quaterniond& q1, double fraction) {
  constexpr double kNearCosine = 0.9998;  // of half the angle: 2.3 degrees
  const double cosine = q0.dot(q1);
  if (std::abs(cosine) < kNearCosine) return q0.slerp(fraction, q1);
  const double toward = cosine < 0 ? -fraction : fraction;
  return Eigen::Quaterniond((1.0 - fraction) * q0.coeffs() + toward * q1.coeffs()).normalized();
}

/// The pose between two poses: linear in translation, spherical in rotation.
/// @param fraction 0 gives `T_A_B0`, 1 gives `T_A_B1`
[[nodiscard]] inline Pose interpolate(const Pose& T_A_B0, const Pose& T_A_B1, double fraction) {
  return make_pose((1.0 - fraction) * T_A_B0.translation() + fraction * T_A_B1.translation(),
                   interpolate(Eigen::Quaterniond(T_A_B0.linear()),
                               Eigen::Quaterniond(T_A_B1.linear()), fraction));
}

/// True when every entry is finite.
[[nodiscard]] inline bool is_finite(const Pose& T_A_B) { return T_A_B.matrix().allFinite(); }

/// True when a pose may be a place: finite, and not as far from the origin as nothing real is. Where an optimiser has
/// diverged, coordinates are no places any more.
[[nodiscard]] inline bool is_place(const Pose& T_A_B) {
  return is_finite(T_A_B) && T_A_B.translation().cwiseAbs().maxCoeff() <= 1e9;
}

/// A rotation is felt at a distance: this far from the sensor, in metres, stands most of what a room's scan sees.
inline constexpr double kLeverM = 5.0;

/// How far a rigid change moves what the sensor sees around it: its shift, and the chord of its turn at kLeverM; metres.
[[nodiscard]] inline double displacement_m(const Pose& T_before_after) {
  // |R - I| is sqrt(8) sin(angle / 2).
  const double chord = (T_before_after.linear() - Eigen::Matrix3d::Identity()).norm() / std::sqrt(2.0);
  return T_before_after.translation().norm() + kLeverM * chord;
}

}  // namespace cloister
