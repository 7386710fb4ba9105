#include "firmware_interface/files/odometry_buffer.hpp"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

SensorTime at_ms(std::int64_t ms) { return {ms * kMillisecond}; }

/// 1 m/s along x and 1 rad/s about z.
Pose pose_at(double seconds) {
  return make_pose({seconds, 0, 0},
                   Eigen::Quaterniond(Eigen::AngleAxisd(seconds, Eigen::Vector3d::UnitZ())));
}

OdometryBuffer steady(std::initializer_list<std::int64_t> stamps_ms) {
  std::vector<StampedPose> samples;
  for (const auto ms : stamps_ms)
    samples.push_back({at_ms(ms), pose_at(static_cast<double>(ms) * 1e-3)});
  return OdometryBuffer(std::move(samples));
}

const OdometryBuffer::Limits kLimits{Duration{200 * kMillisecond}, Duration{50 * kMillisecond}};

void check_pose(const std::optional<Pose>& pose, double seconds) {
  REQUIRE(pose);
  CHECK(pose->isApprox(pose_at(seconds), 1e-9));
}

TEST_CASE("a pose between samples is interpolated, on a sample it is that sample") {
  const auto odometry = steady({0, 100, 200});
  check_pose(odometry.at(at_ms(0), kLimits), 0.0);
  check_pose(odometry.at(at_ms(130), kLimits), 0.13);
  CHECK(odometry.at(at_ms(100), kLimits)->matrix() == pose_at(0.1).matrix());
  check_pose(odometry.at(at_ms(200), kLimits), 0.2);
}

TEST_CASE("beyond the ends velocity is kept, but only so far") {
  const auto odometry = steady({0, 10, 60, 140, 190, 195, 200});
  check_pose(odometry.at(at_ms(-50), kLimits), -0.05);
  CHECK_FALSE(odometry.at(at_ms(-51), kLimits));
  check_pose(odometry.at(at_ms(250), kLimits), 0.25);
  CHECK_FALSE(odometry.at(at_ms(251), kLimits));
}

TEST_CASE("beyond a single sample or next to a gap the pose is taken to rest") {
  CHECK(steady({100}).at(at_ms(120), kLimits)->isApprox(pose_at(0.1), 1e-12));
  CHECK(steady({100}).at(at_ms(80), kLimits)->isApprox(pose_at(0.1), 1e-12));
  CHECK(steady({0, 900}).at(at_ms(920), kLimits)->isApprox(pose_at(0.9), 1e-12));
  CHECK(steady({0, 900}).at(at_ms(-20), kLimits)->isApprox(pose_at(0.0), 1e-12));
  CHECK_FALSE(OdometryBuffer().at(at_ms(0), kLimits));
}

TEST_CASE("nothing is interpolated across a gap") {
  const auto odometry = steady({0, 100, 301, 400});
  CHECK_FALSE(odometry.at(at_ms(150), kLimits));
  CHECK_FALSE(odometry.at(at_ms(101), kLimits));
  CHECK(odometry.at(at_ms(100), kLimits));
  CHECK(odometry.at(at_ms(301), kLimits));
}

TEST_CASE("samples are taken in order only, and the newest may be replaced") {
  OdometryBuffer odometry;
  CHECK(odometry.try_push({at_ms(10), pose_at(0)}));
  CHECK(odometry.try_push({at_ms(20), pose_at(1)}));
  CHECK_FALSE(odometry.try_push({at_ms(15), pose_at(1)}));
  CHECK(odometry.try_push({at_ms(20), pose_at(2)}));
  CHECK(odometry.samples().size() == 2);
  CHECK(odometry.samples().back().T_O_B.translation().x() == 2);
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(odometry.try_push({at_ms(30), broken}));
}

TEST_CASE("forgetting changes no answer from its stamp on and bounds the buffer") {
  OdometryBuffer odometry;
  for (std::int64_t ms = 0; ms < 10'000; ms += 10) {
    REQUIRE(odometry.try_push({at_ms(ms), pose_at(static_cast<double>(ms) * 1e-3)}));
    odometry.forget_before(at_ms(ms - 105));
    check_pose(odometry.at(at_ms(std::max<std::int64_t>(ms - 105, 0)), kLimits),
               static_cast<double>(std::max<std::int64_t>(ms - 105, 0)) * 1e-3);
    REQUIRE(odometry.samples().size() <= 20);
  }
}

TEST_CASE("a covered span holds its interpolated ends and the samples between") {
  const auto odometry = steady({0, 100, 200, 300});
  std::vector<PoseSample> poses;
  CHECK(odometry.cover(at_ms(50), at_ms(250), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kCovered);
  REQUIRE(poses.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    const std::int64_t ms[] = {50, 100, 200, 250};
    CHECK(poses[k].stamp == at_ms(ms[k]));
    check_pose(poses[k].T_R_L, static_cast<double>(ms[k]) * 1e-3);
  }
  CHECK(odometry.cover(at_ms(100), at_ms(300), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kCovered);
  CHECK(poses.size() == 3);
  CHECK(odometry.cover(at_ms(-10), at_ms(340), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kCovered);
  CHECK(poses.size() == 6);
  CHECK(odometry.cover(at_ms(120), at_ms(120), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kCovered);
  CHECK(poses.size() == 1);
}

TEST_CASE("a span that is not covered says why") {
  const auto odometry = steady({0, 100, 400, 500});
  std::vector<PoseSample> poses = {{}};
  CHECK(odometry.cover(at_ms(450), at_ms(551), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kTooLate);
  CHECK(poses.empty());
  CHECK(odometry.cover(at_ms(-51), at_ms(50), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kTooEarly);
  CHECK(odometry.cover(at_ms(50), at_ms(150), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kGap);
  CHECK(odometry.cover(at_ms(50), at_ms(450), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kGap);
  CHECK(odometry.cover(at_ms(100), at_ms(400), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kGap);
  CHECK(OdometryBuffer().cover(at_ms(0), at_ms(1), kLimits, 64, poses) ==
        OdometryBuffer::Coverage::kTooLate);
}

TEST_CASE("more samples than fit are thinned out evenly, without growing past the limit") {
  OdometryBuffer odometry;
  for (std::int64_t ms = 0; ms <= 1000; ++ms) {
    REQUIRE(odometry.try_push({at_ms(ms), pose_at(static_cast<double>(ms) * 1e-3)}));
  }
  for (const std::size_t max_samples : {2, 3, 10, 100, 2000}) {
    CAPTURE(max_samples);
    std::vector<PoseSample> poses;
    REQUIRE(odometry.cover(at_ms(0), at_ms(1000), kLimits, max_samples, poses) ==
            OdometryBuffer::Coverage::kCovered);
    CHECK(poses.size() <= max_samples);
    CHECK(poses.size() >= std::min<std::size_t>(max_samples, 1001) / 2);
    CHECK(poses.front().stamp == at_ms(0));
    CHECK(poses.back().stamp == at_ms(1000));
  }
}

}  // namespace
}  // namespace cloister
