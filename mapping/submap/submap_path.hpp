#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"

namespace cloister {

/// Where the sensor was while it filled a submap: a thinned trail in S, of fixed capacity. When it is full every second
/// point goes, and points are taken at twice the distance from then on.
///
/// Threads: as its submap. No allocation.
class SubmapPath {
 public:
  static constexpr std::size_t kCapacity = 256;

  void clear() { *this = {}; }

  /// Notes a position unless it is close to the one noted last.
  void add(const Eigen::Vector3f& p_S) {
    if (size_ > 0 && (points_[size_ - 1] - p_S).norm() < spacing_m_) return;
    if (size_ == kCapacity) {
      for (std::size_t i = 0; i < kCapacity / 2; ++i) points_[i] = points_[2 * i];
      size_ = kCapacity / 2;
      spacing_m_ *= 2;
    }
    points_[size_++] = p_S;
  }

  /// S becomes another frame. @param T_S_new  its pose in S so far
  void move_frame(const Pose& T_S_new) {
    const Eigen::Isometry3f T_new_S = T_S_new.inverse().cast<float>();
    for (std::size_t i = 0; i < size_; ++i) points_[i] = T_new_S * points_[i];
  }

  [[nodiscard]] std::span<const Eigen::Vector3f> points() const { return {points_.data(), size_}; }

  /// Square of how near the trail comes to a place in S, m^2; infinite for an empty trail.
  [[nodiscard]] float squared_distance(const Eigen::Vector3f& p_S) const {
    float nearest_m2 = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < size_; ++i) nearest_m2 = std::min(nearest_m2, (points_[i] - p_S).squaredNorm());
    return nearest_m2;
  }

 private:
  std::array<Eigen::Vector3f, kCapacity> points_;
  std::size_t size_ = 0;
  float spacing_m_ = 0.25f;
};

}  // namespace cloister
