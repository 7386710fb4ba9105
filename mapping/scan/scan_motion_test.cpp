#include "mapping/scan/scan_motion.hpp"

#include <vector>

#include <doctest/doctest.h>

namespace cloister {
namespace {

Pose turned(double angle_rad, double x_m) {
  return make_pose({x_m, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(
                                    angle_rad, Eigen::Vector3d(1, 2, 3).normalized())));
}

SensorTime at_us(std::int64_t us) { return {us * 1000}; }

/// Samples 10 ms apart of a sensor that turns and moves evenly.
std::vector<PoseSample> even_motion(double step_rad) {
  std::vector<PoseSample> samples;
  for (int i = 0; i < 6; ++i) samples.push_back({at_us(10'000 * i), turned(step_rad * i, 0.1 * i)});
  return samples;
}

TEST_CASE("between its samples the sensor moves and turns evenly, near or far apart") {
  for (const double step_rad : {0.0, 1e-3, 0.03, 0.05, 0.5, 2.0}) {
    CAPTURE(step_rad);
    const std::vector<PoseSample> samples = even_motion(step_rad);
    ScanMotion motion(samples);
    for (int us = 0; us <= 50'000; us += 777) {
      const double steps = us / 10'000.0;
      const Pose error = turned(step_rad * steps, 0.1 * steps).inverse() * motion.T_R_L(at_us(us));
      CHECK(error.translation().norm() < 1e-12);
      CHECK((error.linear() - Eigen::Matrix3d::Identity()).norm() < 1e-6);
    }
  }
}

TEST_CASE("outside its samples the sensor stands, and stamps may come in any order") {
  const std::vector<PoseSample> samples = even_motion(0.02);
  ScanMotion motion(samples);
  CHECK(motion.T_R_L(at_us(99'000)).matrix() == samples.back().T_R_L.matrix());
  CHECK(motion.T_R_L(at_us(-5)).matrix() == samples.front().T_R_L.matrix());
  for (const int us : {44'000, 3'000, 21'000, 20'000, 9'999}) {
    ScanMotion fresh(samples);
    CHECK(motion.T_R_L(at_us(us)).matrix() == fresh.T_R_L(at_us(us)).matrix());
  }
}

TEST_CASE("one sample, and two of one stamp, are poses as well") {
  const std::vector<PoseSample> one{{at_us(5), turned(1, 2)}};
  CHECK(ScanMotion(one).T_R_L(at_us(7)).matrix() == one[0].T_R_L.matrix());
  const std::vector<PoseSample> twice{
      {at_us(5), turned(0, 0)}, {at_us(5), turned(1, 1)}, {at_us(9), turned(1, 1)}};
  CHECK(ScanMotion(twice).T_R_L(at_us(7)).isApprox(turned(1, 1), 1e-12));
}

}  // namespace
}  // namespace cloister
