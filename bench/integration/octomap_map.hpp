#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "bench/integration/placed_scan.hpp"
#include "mapping/core/config.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// OctoMap as its documentation uses it: whole clouds from one sensor origin, neither lazy nor discretised, with the
/// same resolution, probabilities and limits.
class OctomapMap {
 public:
  explicit OctomapMap(const VoxelConfig& config);
  ~OctomapMap();

  /// Takes the scan's points over into OctoMap's own type; not a part of what is measured.
  void prepare(const std::vector<Beam>& beams, const Eigen::Vector3f& sensor_S);
  /// Inserts the scan that was prepared.
  void integrate();

  [[nodiscard]] VoxelState state(const Eigen::Vector3f& p_S) const;
  [[nodiscard]] double observed_m3() const;
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloister
