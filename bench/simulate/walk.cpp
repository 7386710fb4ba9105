#include "bench/simulate/walk.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

constexpr double kSpacing_m = 0.005;
constexpr double kStep_s = 0.01;

/// Weighted mean with a Gaussian window; past the ends the values go on mirrored in the end
/// point, so that the ends stay where they are.
template <typename T>
std::vector<T> smooth(const std::vector<T>& values, double sigma_samples) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma_samples));
  std::vector<double> weights(static_cast<std::size_t>(reach) + 1);
  double total = 0.0;
  for (int k = 0; k <= reach; ++k) {
    weights[k] = std::exp(-0.5 * k * k / (sigma_samples * sigma_samples));
    total += k == 0 ? weights[k] : 2.0 * weights[k];
  }
  const int last = static_cast<int>(values.size()) - 1;
  const auto value = [&](int i) -> T {
    if (i < 0) return 2.0 * values.front() - values[std::min(last, -i)];
    if (i > last) return 2.0 * values.back() - values[std::max(0, 2 * last - i)];
    return values[i];
  };
  std::vector<T> out(values.size());
  for (int i = 0; i <= last; ++i) {
    T sum = weights[0] * values[i];
    for (int k = 1; k <= reach; ++k) sum += weights[k] * (value(i - k) + value(i + k));
    out[i] = sum / total;
  }
  return out;
}

/// The rounded path, evenly spaced, and where along it one pauses.
struct Line {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> pause_s;
};

Line round_corners(std::span<const Waypoint> path, double corner_m) {
  Line line;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const Eigen::Vector3d a = path[k].position_W;
    const Eigen::Vector3d b = path[k + 1].position_W;
    const int count = static_cast<int>(std::ceil((b - a).norm() / kSpacing_m));
    for (int n = 0; n < count; ++n) {
      line.points.push_back(a + (b - a) * n / count);
      line.pause_s.push_back(n == 0 ? path[k].pause_s : 0.0);
    }
  }
  line.points.push_back(path.back().position_W);
  line.pause_s.push_back(0.0);
  line.points = smooth(line.points, corner_m / kSpacing_m);
  return line;
}

/// The speed at every point: limits by bend and slope first, then braking and speeding up within
/// the acceleration.
std::vector<double> plan_speed(const Line& line, const WalkConfig& config) {
  const int last = static_cast<int>(line.points.size()) - 1;
  std::vector<double> speed(line.points.size());
  constexpr int kReach = 10;
  for (int i = 0; i <= last; ++i) {
    const Eigen::Vector3d before = line.points[i] - line.points[std::max(0, i - kReach)];
    const Eigen::Vector3d after = line.points[std::min(last, i + kReach)] - line.points[i];
    double limit = config.speed_mps;
    if (before.norm() > 1e-9 && after.norm() > 1e-9) {
      const double turn =
          std::acos(std::clamp(before.normalized().dot(after.normalized()), -1.0, 1.0));
      const double bend = turn / (0.5 * (before.norm() + after.norm()));
      limit = std::min(limit, 0.7 * config.max_yaw_rate_radps / std::max(bend, 1e-6));
      if (std::abs(after.normalized().z()) > 0.2) limit = std::min(limit, config.stairs_speed_mps);
    }
    speed[i] = line.pause_s[i] > 0.0 ? 0.0 : std::max(limit, 0.05);
  }
  speed.front() = speed.back() = 0.0;
  for (int i = 1; i <= last; ++i) {
    const double ds = (line.points[i] - line.points[i - 1]).norm();
    speed[i] = std::min(
        speed[i], std::sqrt(speed[i - 1] * speed[i - 1] + 2.0 * config.acceleration_mps2 * ds));
  }
  for (int i = last - 1; i >= 0; --i) {
    const double ds = (line.points[i + 1] - line.points[i]).norm();
    speed[i] = std::min(
        speed[i], std::sqrt(speed[i + 1] * speed[i + 1] + 2.0 * config.acceleration_mps2 * ds));
  }
  return speed;
}

/// Positions at 100 Hz along the line with the planned speed.
std::vector<Eigen::Vector3d> pace(const Line& line, const WalkConfig& config) {
  const std::vector<double> speed = plan_speed(line, config);
  std::vector<double> arrival_s = {config.rest_s};
  std::vector<double> leave_s = {config.rest_s};
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    const double ds = (line.points[i] - line.points[i - 1]).norm();
    arrival_s.push_back(leave_s.back() + 2.0 * ds / std::max(speed[i] + speed[i - 1], 1e-3));
    leave_s.push_back(arrival_s.back() + line.pause_s[i]);
  }
  std::vector<Eigen::Vector3d> positions;
  std::size_t i = 0;
  for (double t = 0.0; t <= leave_s.back() + config.rest_s;
       t = static_cast<double>(positions.size()) * kStep_s) {
    while (i + 1 < line.points.size() && arrival_s[i + 1] <= t) ++i;
    Eigen::Vector3d p = line.points[i];
    if (i + 1 < line.points.size() && t > leave_s[i]) {
      const double fraction = (t - leave_s[i]) / std::max(arrival_s[i + 1] - leave_s[i], 1e-9);
      p += (line.points[i + 1] - line.points[i]) * fraction;
    }
    positions.push_back(p);
  }
  return smooth(positions, 12.0);
}

/// Yaw that looks a little ahead along the path, limited in its rate.
std::vector<double> look_ahead(const std::vector<Eigen::Vector3d>& positions,
                               double max_rate_radps) {
  constexpr double kAhead_m = 0.35;
  const auto heading_from = [&](std::size_t k, double* yaw) {
    for (std::size_t n = k + 1; n < positions.size(); ++n) {
      const Eigen::Vector2d d = (positions[n] - positions[k]).head<2>();
      if (d.norm() < kAhead_m) continue;
      *yaw = std::atan2(d.y(), d.x());
      return true;
    }
    return false;
  };
  std::vector<double> yaw(positions.size(), 0.0);
  double now = 0.0;
  heading_from(0, &now);
  for (std::size_t k = 0; k < positions.size(); ++k) {
    double target = now;
    heading_from(k, &target);
    const double turn = std::remainder(target - now, 2.0 * std::numbers::pi);
    now += std::clamp(turn, -max_rate_radps * kStep_s, max_rate_radps * kStep_s);
    yaw[k] = now;
  }
  return smooth(yaw, 15.0);
}

}  // namespace

Trajectory walk(std::span<const Waypoint> path, const WalkConfig& config, SensorTime start,
                std::uint64_t seed) {
  const std::vector<Eigen::Vector3d> positions = pace(round_corners(path, config.corner_m), config);
  const std::vector<double> yaw = look_ahead(positions, config.max_yaw_rate_radps);
  std::vector<double> vigour(positions.size(), 0.0);
  for (std::size_t k = 1; k < positions.size(); ++k) {
    vigour[k] =
        std::min(1.0, (positions[k] - positions[k - 1]).norm() / (kStep_s * config.speed_mps));
  }
  vigour = smooth(vigour, 20.0);

  // Steps: up and down, pitch and roll once per step; swaying and yaw once per pair of steps. The
  // gait is not a clock.
  RandomStream random = random_stream(seed, Purpose::kShake);
  double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  double rhythm = 0.0;
  Trajectory trajectory{start, Duration::from_seconds(kStep_s), {}};
  trajectory.poses.reserve(positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    rhythm += -0.02 * rhythm + 0.02 * random.normal();
    phase += 2.0 * std::numbers::pi * config.shake_hz * (1.0 + 0.5 * rhythm) * kStep_s;
    const double d = config.shake_m * vigour[k];
    const double a = config.shake_rad * vigour[k];
    const Eigen::Vector3d sway(0.5 * d * std::sin(phase), d * std::sin(0.5 * phase),
                               d * std::cos(phase));
    const Eigen::Quaterniond q =
        Eigen::AngleAxisd(yaw[k] + 0.5 * a * std::sin(0.5 * phase), Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(a * std::sin(phase + 0.8), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(a * std::cos(phase + 0.3), Eigen::Vector3d::UnitX());
    const Eigen::AngleAxisd R_W_yaw(yaw[k], Eigen::Vector3d::UnitZ());
    trajectory.poses.push_back(make_pose(positions[k] + R_W_yaw * sway, q));
  }
  return trajectory;
}

Trajectory resample(const std::vector<StampedPose>& poses, SensorTime start) {
  Trajectory trajectory{start, Duration::from_seconds(kStep_s), {}};
  for (SensorTime at = poses.front().stamp; at <= poses.back().stamp; at = at + trajectory.step) {
    trajectory.poses.push_back(pose_at(poses, at));
  }
  return trajectory;
}

}  // namespace cloister
