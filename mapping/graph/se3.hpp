#pragma once

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/graph/pose_graph.hpp"

/// The Lie group SE(3) in the convention of every graph file here: a tangent vector is (translation
/// [m], rotation vector [rad]), in that order, and perturbations act from the right:
/// `T = mean * Exp(xi)`.
///
/// With W = [w]x and theta = |w|. Sources: T. Barfoot, "State Estimation for Robotics", 2nd ed.,
/// chapter 8; J. Sola et al., "A micro Lie theory for state estimation in robotics" (2018), section
/// IV and appendix D.
/// Threads: pure functions. Real-time: no allocation.
namespace cloister {

/// A tangent vector of SE(3): (translation [m], rotation vector [rad]).
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Exp(v, w) = (exp(W), V v), V = I + (1 - cos theta)/theta^2 W + (theta - sin theta)/theta^3 W^2.
[[nodiscard]] Pose se3_exp(const Vector6d& xi);

/// The inverse of se3_exp with |w| <= pi, by V^-1 = I - W/2 + c W^2 with
/// c = (1 - (theta/2) cot(theta/2)) / theta^2. Accurate near zero and near pi; at exactly pi the
/// sign of w is one of the two that are right.
[[nodiscard]] Vector6d se3_log(const Pose& T);

/// Ad(T) = [[R, [t]x R], [0, R]]: `T * Exp(xi) = Exp(Ad(T) xi) * T`.
[[nodiscard]] Matrix6d se3_adjoint(const Pose& T);

/// Inverse right Jacobian, for theta < 2 pi:
/// `Log(Exp(xi) * Exp(delta)) = xi + Jr^-1(xi) delta + O(|delta|^2)`.
///
/// Jr^-1(xi) = sum over n of (-1)^n B_n / n! ad(xi)^n (Bernoulli numbers, B_1 = -1/2). Its odd part
/// is ad/2 alone. Since ad (ad^2 + theta^2)^2 = 0, the even part is a polynomial of degree 4 in ad
/// that agrees with (x/2) coth(x/2) in value and slope at x = i theta:
/// I + (c - s c') ad^2 - c' ad^4 with s = theta^2, c(s) as in se3_log and c' = dc/ds.
[[nodiscard]] Matrix6d se3_inverse_right_jacobian(const Vector6d& xi);

}  // namespace cloister
