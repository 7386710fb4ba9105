#include "firmware_interface/files/odometry_buffer.hpp"

#include <algorithm>

namespace cloister {
namespace {

/// A velocity is taken over at least this time: that of two close samples is mostly their noise.
constexpr Duration kVelocitySpan{50'000'000};

/// The first sample at or after a stamp.
auto first_from(std::span<const StampedPose> samples, SensorTime stamp) {
  return std::ranges::lower_bound(samples, stamp, {}, &StampedPose::stamp);
}

Pose between(const StampedPose& a, const StampedPose& b, SensorTime stamp) {
  return interpolate(a.T_O_B, b.T_O_B, (stamp - a.stamp).seconds() / (b.stamp - a.stamp).seconds());
}

}  // namespace

bool OdometryBuffer::try_push(const StampedPose& sample) {
  if (!is_finite(sample.T_O_B)) return false;
  const auto known = samples();
  if (!known.empty() && sample.stamp <= known.back().stamp) {
    if (sample.stamp < known.back().stamp) return false;
    samples_.back() = sample;
    return true;
  }
  samples_.push_back(sample);
  return true;
}

void OdometryBuffer::forget_before(SensorTime stamp) {
  const auto known = samples();
  const auto next = first_from(known, stamp - kVelocitySpan);
  // One sample from before the stamp stays, to interpolate from.
  if (next == known.begin()) return;
  num_forgotten_ += static_cast<std::size_t>(next - known.begin()) - 1;
  if (num_forgotten_ > samples_.size() / 2) {
    samples_.erase(samples_.begin(),
                   samples_.begin() + static_cast<std::ptrdiff_t>(num_forgotten_));
    num_forgotten_ = 0;
  }
}

std::optional<Pose> OdometryBuffer::at(SensorTime stamp, const Limits& limits) const {
  const auto known = samples();
  if (known.empty()) return std::nullopt;
  const auto next = first_from(known, stamp);
  if (next != known.end() && next->stamp == stamp) return next->T_O_B;

  if (next == known.begin()) {
    const StampedPose& first = known.front();
    if (first.stamp - stamp > limits.max_extrapolation) return std::nullopt;
    const auto other = first_from(known, first.stamp + kVelocitySpan);
    if (other == known.end() || other->stamp - first.stamp > limits.max_gap) return first.T_O_B;
    return between(first, *other, stamp);
  }
  if (next == known.end()) {
    const StampedPose& last = known.back();
    if (stamp - last.stamp > limits.max_extrapolation) return std::nullopt;
    const auto after = first_from(known, last.stamp - kVelocitySpan + Duration{1});
    if (after == known.begin()) return last.T_O_B;
    const StampedPose& other = *(after - 1);
    if (last.stamp - other.stamp > limits.max_gap) return last.T_O_B;
    return between(other, last, stamp);
  }
  const StampedPose& previous = *(next - 1);
  if (next->stamp - previous.stamp > limits.max_gap) return std::nullopt;
  return between(previous, *next, stamp);
}

OdometryBuffer::Coverage OdometryBuffer::cover(SensorTime begin, SensorTime end,
                                               const Limits& limits, std::size_t max_samples,
                                               std::vector<PoseSample>& poses) const {
  poses.clear();
  const auto known = samples();
  if (known.empty() || end - known.back().stamp > limits.max_extrapolation) {
    return Coverage::kTooLate;
  }
  if (known.front().stamp - begin > limits.max_extrapolation) return Coverage::kTooEarly;

  const auto T_O_B_begin = at(begin, limits);
  const auto T_O_B_end = at(end, limits);
  if (!T_O_B_begin || !T_O_B_end) return Coverage::kGap;
  // Samples within the span, ends included; what lies outside of them `at` has looked at.
  auto first = first_from(known, begin);
  auto stop = first_from(known, end + Duration{1});
  for (auto it = first; stop - it > 1; ++it) {
    if ((it + 1)->stamp - it->stamp > limits.max_gap) return Coverage::kGap;
  }

  poses.push_back({begin, *T_O_B_begin});
  if (first < stop && first->stamp == begin) ++first;
  if (first < stop && (stop - 1)->stamp == end) --stop;
  const auto num_between = static_cast<std::size_t>(stop - first);
  if (const std::size_t room = max_samples > 2 ? max_samples - 2 : 0; room > 0) {
    const auto stride = static_cast<std::ptrdiff_t>((num_between + room - 1) / room);
    for (auto it = first; it < stop; it += std::min(stride, stop - it)) {
      poses.push_back({it->stamp, it->T_O_B});
    }
  }
  if (begin < end) poses.push_back({end, *T_O_B_end});
  return Coverage::kCovered;
}

}  // namespace cloister
