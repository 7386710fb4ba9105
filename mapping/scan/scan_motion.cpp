#include "mapping/scan/scan_motion.hpp"

namespace cloister {

ScanMotion::ScanMotion(std::span<const PoseSample> samples) : samples_(samples) {
  if (samples_.size() > 1) go_to(0);
}

void ScanMotion::go_to(std::size_t sample) {
  before_ = sample;
  q_before_ = Eigen::Quaterniond(samples_[sample].T_R_L.linear());
  q_after_ = Eigen::Quaterniond(samples_[sample + 1].T_R_L.linear());
}

Pose ScanMotion::T_R_L(SensorTime stamp) {
  if (samples_.size() == 1 || stamp <= samples_.front().stamp) return samples_.front().T_R_L;
  if (stamp >= samples_.back().stamp) return samples_.back().T_R_L;
  std::size_t sample = before_;
  while (sample > 0 && samples_[sample].stamp > stamp) --sample;
  while (sample + 2 < samples_.size() && samples_[sample + 1].stamp <= stamp) ++sample;
  if (sample != before_) go_to(sample);
  const PoseSample& before = samples_[before_];
  const PoseSample& after = samples_[before_ + 1];
  const double span_ns = static_cast<double>((after.stamp - before.stamp).ns);
  if (span_ns <= 0) return after.T_R_L;
  const double fraction = static_cast<double>((stamp - before.stamp).ns) / span_ns;
  Pose T_R_L = Pose::Identity();
  T_R_L.linear() = interpolate(q_before_, q_after_, fraction).toRotationMatrix();
  T_R_L.translation() =
      (1.0 - fraction) * before.T_R_L.translation() + fraction * after.T_R_L.translation();
  return T_R_L;
}

}  // namespace cloister
