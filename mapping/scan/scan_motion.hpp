#pragma once

#include <cstddef>
#include <span>

#include "mapping/scan/scan.hpp"

namespace cloister {

/// Where the sensor was during a scan: interpolated between the scan's samples, held constant outside them. Stamps are
/// asked for in order, as columns come: what two samples need is prepared once.
///
/// No allocation; the samples must outlive it.
class ScanMotion {
 public:
  /// @param samples  sorted by stamp, at least one
  explicit ScanMotion(std::span<const PoseSample> samples);

  [[nodiscard]] Pose T_R_L(SensorTime stamp);

 private:
  void go_to(std::size_t sample);

  std::span<const PoseSample> samples_;
  std::size_t before_ = 0;  ///< of the two samples between which stamps are asked for, the first
  Eigen::Quaterniond q_before_, q_after_;
};

}  // namespace cloister
