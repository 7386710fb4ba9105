#include "mapping/graph/se3.hpp"

#include <cmath>

namespace cloister {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d skew(const Vector3d& w) {
  Matrix3d W;
  W << 0.0, -w.z(), w.y(),  //
      w.z(), 0.0, -w.x(),   //
      -w.y(), w.x(), 0.0;
  return W;
}

/// c(s) = (1 - h cot h) / s with h = sqrt(s) / 2, and its derivative by s.
struct Cotangent {
  double c;
  double dc_ds;
};

Cotangent cotangent_terms(double s) {
  // Below theta = 0.5 the closed forms lose digits; the series |B_2k| / (2k)! s^(k-1), k = 1..7,
  // leaves out less than 1e-15. Both forms meet there to 1e-14 (c) and 1e-12 (c', which is only
  // ever multiplied by s^2).
  if (s < 0.25) {
    constexpr double k1 = 1.0 / 12.0;
    constexpr double k2 = 1.0 / 720.0;
    constexpr double k3 = 1.0 / 30240.0;
    constexpr double k4 = 1.0 / 1209600.0;
    constexpr double k5 = 1.0 / 47900160.0;
    constexpr double k6 = 691.0 / 1307674368000.0;
    constexpr double k7 = 1.0 / 74724249600.0;
    return {k1 + s * (k2 + s * (k3 + s * (k4 + s * (k5 + s * (k6 + s * k7))))),
            k2 + s * (2 * k3 + s * (3 * k4 + s * (4 * k5 + s * (5 * k6 + s * 6 * k7))))};
  }
  const double h = 0.5 * std::sqrt(s);
  const double sin_h = std::sin(h);
  const double cot_h = std::cos(h) / sin_h;
  const double c = (1.0 - h * cot_h) / s;
  // d(h cot h)/ds = (cot h - h / sin^2 h) / (8 h), and 1 - s c = h cot h.
  const double dg_ds = (cot_h - h / (sin_h * sin_h)) / (8.0 * h);
  return {c, -(dg_ds + c) / s};
}

}  // namespace

Pose se3_exp(const Vector6d& xi) {
  const Vector3d w = xi.tail<3>();
  const double s = w.squaredNorm();
  double a = 0.0;  // sin(theta) / theta
  double b = 0.0;  // (1 - cos(theta)) / theta^2
  double d = 0.0;  // (theta - sin(theta)) / theta^3
  if (s < 0.01) {
    a = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)));
    b = 0.5 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0))));
    d = (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))) / 6.0;
  } else {
    const double theta = std::sqrt(s);
    const double sin_half = std::sin(0.5 * theta);
    a = std::sin(theta) / theta;
    b = 2.0 * sin_half * sin_half / s;
    d = (1.0 - a) / s;
  }
  const Matrix3d W = skew(w);
  const Matrix3d W2 = W * W;
  Pose T = Pose::Identity();
  T.linear() = Matrix3d::Identity() + a * W + b * W2;
  T.translation() = xi.head<3>() + b * (W * xi.head<3>()) + d * (W2 * xi.head<3>());
  return T;
}

Vector6d se3_log(const Pose& T) {
  // By way of the quaternion, whose vector part is well conditioned at pi where the matrix's odd
  // part vanishes.
  const Eigen::Quaterniond q(T.linear());
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double sin_half = q.vec().norm();
  const double scale = sin_half > 0.0 ? 2.0 * std::atan2(sin_half, sign * q.w()) / sin_half : 2.0;
  const Vector3d w = sign * scale * q.vec();
  const Matrix3d W = skew(w);
  const Vector3d t = T.translation();
  Vector6d xi;
  xi << t - 0.5 * (W * t) + cotangent_terms(w.squaredNorm()).c * (W * (W * t)), w;
  return xi;
}

Matrix6d se3_adjoint(const Pose& T) {
  Matrix6d adjoint;
  adjoint << T.linear(), skew(T.translation()) * T.linear(), Matrix3d::Zero(), T.linear();
  return adjoint;
}

Matrix6d se3_inverse_right_jacobian(const Vector6d& xi) {
  // ad = [[W, U], [0, W]], so ad^2 = [[W^2, M], [0, W^2]] and ad^4 = [[W^4, W^2 M + M W^2], [0,
  // W^4]] with M = W U + U W and W^4 = -s W^2: on the diagonal the polynomial shrinks to I + W/2 +
  // c W^2.
  const Matrix3d U = skew(xi.head<3>());
  const Matrix3d W = skew(xi.tail<3>());
  const double s = xi.tail<3>().squaredNorm();
  const auto [c, dc_ds] = cotangent_terms(s);
  const Matrix3d W2 = W * W;
  const Matrix3d M = W * U + U * W;
  const Matrix3d diagonal = Matrix3d::Identity() + 0.5 * W + c * W2;
  const Matrix3d coupling = 0.5 * U + (c - s * dc_ds) * M - dc_ds * (W2 * M + M * W2);
  Matrix6d jacobian;
  jacobian << diagonal, coupling, Matrix3d::Zero(), diagonal;
  return jacobian;
}

}  // namespace cloister
