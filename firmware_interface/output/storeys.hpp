#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/record/mission_record.hpp"

namespace cloister {

/// One level of a mission: the part of the path that was walked on it.
struct Storey {
  double sensor_z_m = 0;  ///< median height of the sensor while on it, in M
  /// Path on the level itself, stairs left out, a point every 0.2 m or more.
  std::vector<Eigen::Vector3d> level_M;
};

/// The levels of a path and which of them each pose belongs to.
struct Storeys {
  std::vector<Storey> storeys;       ///< bottom up; one at least, also for an empty path
  std::vector<std::size_t> of_pose;  ///< [path], index into `storeys`
};

/// Finds the levels on which a sensor was carried. Heights where the path dwells (peaks of its
/// length over z, at least 1.5 m apart, with a dip between them) are levels; two of them become
/// separate storeys only where one lies above the other, so that a walk over hills stays one plan
/// however high it climbs.
[[nodiscard]] Storeys find_storeys(const std::vector<std::pair<SensorTime, Pose>>& path_M);

/// Height of the ground under a storey's path, anywhere around it: that of the nearest stretch of
/// the path, less the height at which the sensor is carried.
class GroundLevel {
 public:
  /// @param storey whose level is taken; without any path the level is 0
  /// @param min_M, max_M x and y that will be asked for; outside, the border's answer is given
  GroundLevel(const Storey& storey, const Eigen::Vector2d& min_M, const Eigen::Vector2d& max_M);

  /// Height of the sensor on the nearest stretch of the path.
  [[nodiscard]] double sensor_z(double x_M, double y_M) const { return z_[cell(x_M, y_M)]; }

  /// True within about two metres of the path.
  [[nodiscard]] bool is_near_path(double x_M, double y_M) const {
    return near_[cell(x_M, y_M)] != 0;
  }

 private:
  [[nodiscard]] std::size_t cell(double x_M, double y_M) const;

  Eigen::Vector2d min_M_;
  double cell_m_ = 2.0;
  int columns_ = 1, rows_ = 1;
  std::vector<double> z_;
  std::vector<std::uint8_t> near_;
};

}  // namespace cloister
