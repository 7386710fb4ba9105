#include "mapping/graph/se3.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr double kPi = std::numbers::pi;

/// A tangent vector with the given angle [rad] about a random axis, and a translation of a few
/// metres.
Vector6d random_tangent(std::mt19937& random, double angle_rad) {
  std::normal_distribution<double> normal;
  Vector6d xi;
  for (double& entry : xi) entry = normal(random);
  xi.tail<3>() *= angle_rad / xi.tail<3>().norm();
  return xi;
}

double max_difference(const auto& a, const auto& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Exp(xi) as a truncated power series of the 4x4 matrix: slow and obvious.
Eigen::Matrix4d exp_by_series(const Vector6d& xi) {
  Eigen::Matrix4d X = Eigen::Matrix4d::Zero();
  X.topLeftCorner<3, 3>() << 0.0, -xi(5), xi(4), xi(5), 0.0, -xi(3), -xi(4), xi(3), 0.0;
  X.topRightCorner<3, 1>() = xi.head<3>();
  Eigen::Matrix4d term = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d sum = term;
  for (int n = 1; n < 60; ++n) {
    term = (term * X / n).eval();
    sum += term;
  }
  return sum;
}

/// From no rotation at all to almost half a turn, with the angles where a series gives way to a
/// closed form.
constexpr double kAngles_rad[] = {1e-300, 1e-12,  1e-8, 1e-5, 1e-3, 0.0999, 0.1001,
                                  0.4999, 0.5001, 1.0,  2.0,  3.0,  3.14159};

}  // namespace

TEST_CASE("the exponential agrees with the power series of its matrix") {
  constexpr unsigned seed = 11;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (const double angle_rad : kAngles_rad) {
    CAPTURE(angle_rad);
    for (int n = 0; n < 20; ++n) {
      const Vector6d xi = random_tangent(random, angle_rad);
      CHECK(max_difference(se3_exp(xi).matrix(), exp_by_series(xi)) < 1e-13);
    }
  }
}

TEST_CASE("the logarithm undoes the exponential from zero to half a turn") {
  constexpr unsigned seed = 12;
  CAPTURE(seed);
  std::mt19937 random(seed);
  CHECK(se3_log(Pose::Identity()) == Vector6d::Zero());
  CHECK(se3_exp(Vector6d::Zero()).matrix() == Eigen::Matrix4d::Identity());
  for (const double angle_rad : kAngles_rad) {
    CAPTURE(angle_rad);
    for (int n = 0; n < 20; ++n) {
      const Vector6d xi = random_tangent(random, angle_rad);
      CHECK(max_difference(se3_log(se3_exp(xi)), xi) < 1e-13);
    }
  }
}

TEST_CASE("at half a turn the logarithm gives one of the two vectors that lead back") {
  constexpr unsigned seed = 13;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (int n = 0; n < 50; ++n) {
    const Pose T = se3_exp(random_tangent(random, kPi));
    const Vector6d xi = se3_log(T);
    CHECK(xi.tail<3>().norm() == doctest::Approx(kPi));
    CHECK(max_difference(se3_exp(xi).matrix(), T.matrix()) < 1e-13);
  }
}

TEST_CASE("the adjoint carries a perturbation from the right of a pose to its left") {
  constexpr unsigned seed = 14;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (const double angle_rad : kAngles_rad) {
    CAPTURE(angle_rad);
    const Pose T = se3_exp(random_tangent(random, angle_rad));
    const Matrix6d adjoint = se3_adjoint(T);
    const Vector6d delta = random_tangent(random, 0.7);
    CHECK(max_difference((T * se3_exp(delta)).matrix(), (se3_exp(adjoint * delta) * T).matrix()) <
          1e-13);

    Matrix6d numeric;  // central differences of T Exp(delta) T^-1
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = kStep * Vector6d::Unit(k);
      numeric.col(k) =
          (se3_log(T * se3_exp(step) * T.inverse()) - se3_log(T * se3_exp(-step) * T.inverse())) /
          (2.0 * kStep);
    }
    CHECK(max_difference(adjoint, numeric) < 1e-8);
  }
}

TEST_CASE("the inverse right Jacobian agrees with central differences") {
  constexpr unsigned seed = 15;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (const double angle_rad : {1e-12, 1e-6, 1e-3, 0.1, 0.4999, 0.5001, 1.0, 2.0, 3.0}) {
    CAPTURE(angle_rad);
    for (int n = 0; n < 10; ++n) {
      const Vector6d xi = random_tangent(random, angle_rad);
      Matrix6d numeric;
      constexpr double kStep = 1e-5;
      for (int k = 0; k < 6; ++k) {
        const Vector6d step = kStep * Vector6d::Unit(k);
        numeric.col(k) =
            (se3_log(se3_exp(xi) * se3_exp(step)) - se3_log(se3_exp(xi) * se3_exp(-step))) /
            (2.0 * kStep);
      }
      CHECK(max_difference(se3_inverse_right_jacobian(xi), numeric) < 1e-8);
    }
  }
}

TEST_CASE("the inverse right Jacobian has no step where its series ends") {
  constexpr unsigned seed = 16;
  CAPTURE(seed);
  std::mt19937 random(seed);
  CHECK(se3_inverse_right_jacobian(Vector6d::Zero()) == Matrix6d::Identity());
  for (int n = 0; n < 50; ++n) {
    const Vector6d xi = random_tangent(random, 1.0);
    Vector6d below = xi;
    Vector6d above = xi;
    below.tail<3>() *= 0.5 * (1.0 - 1e-14);
    above.tail<3>() *= 0.5 * (1.0 + 1e-14);
    CHECK(max_difference(se3_inverse_right_jacobian(below), se3_inverse_right_jacobian(above)) <
          1e-12);
  }
}

}  // namespace cloister
