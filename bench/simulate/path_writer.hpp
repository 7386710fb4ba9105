#pragma once

#include <utility>
#include <vector>

#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {

/// Collects waypoints by where the feet are.
class PathWriter {
 public:
  PathWriter(double sensor_height_m, RandomStream* random)
      : sensor_height_m_(sensor_height_m), random_(random) {}

  void set_floor(double z) { floor_z_ = z; }
  void exact(double x, double y) { path_.push_back({{x, y, floor_z_ + sensor_height_m_}, 0.0}); }
  /// A place inside a room: nobody walks the same line twice.
  void around(double x, double y, double pause_s = 0.0, double spread_m = 0.18) {
    const double dx = random_->uniform(-spread_m, spread_m);
    const double dy = random_->uniform(-spread_m, spread_m);
    path_.push_back({{x + dx, y + dy, floor_z_ + sensor_height_m_}, pause_s});
  }
  /// Straight through a doorway of a wall that runs along y (at x) or along x (at y); `sign` is the
  /// way walked.
  void through_wall_at_x(double x, double y, double sign) {
    for (const double offset : {-0.6, 0.0, 0.6}) exact(x + sign * offset, y);
  }
  void through_wall_at_y(double x, double y, double sign) {
    for (const double offset : {-0.6, 0.0, 0.6}) exact(x, y + sign * offset);
  }
  [[nodiscard]] std::vector<Waypoint> take() { return std::move(path_); }

 private:
  double sensor_height_m_;
  RandomStream* random_;
  double floor_z_ = 0.0;
  std::vector<Waypoint> path_;
};

/// The straight lines between waypoints as points about `spacing_m` apart.
[[nodiscard]] std::vector<Eigen::Vector3d> densify(const std::vector<Waypoint>& path,
                                                   double spacing_m = 0.05);

}  // namespace cloister
