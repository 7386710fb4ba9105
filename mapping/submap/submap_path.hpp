#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

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

  /// Appends another submap's trail.
  void add(const SubmapPath& other, const Pose& T_S_other) {
    const Eigen::Isometry3f T = T_S_other.cast<float>();
    for (std::size_t i = 0; i < other.size_; ++i) add(T * other.points_[i]);
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Share of the shorter of both trails that comes within `radius_m` of the other; 0 when one is empty.
  [[nodiscard]] static double shared(const SubmapPath& a, const SubmapPath& b, const Pose& T_b_a, float radius_m) {
    if (a.size_ > b.size_) return shared(b, a, T_b_a.inverse(), radius_m);
    if (a.size_ == 0) return 0;
    const Eigen::Isometry3f T = T_b_a.cast<float>();
    std::size_t num_near = 0;
    for (std::size_t i = 0; i < a.size_; ++i) {
      const Eigen::Vector3f p_b = T * a.points_[i];
      num_near += std::any_of(b.points_.begin(), b.points_.begin() + static_cast<std::ptrdiff_t>(b.size_),
                              [&](const Eigen::Vector3f& q_b) { return (q_b - p_b).norm() < radius_m; });
    }
    return static_cast<double>(num_near) / static_cast<double>(a.size_);
  }

 private:
  std::array<Eigen::Vector3f, kCapacity> points_;
  std::size_t size_ = 0;
  float spacing_m_ = 0.25f;
};

}  // namespace cloister
