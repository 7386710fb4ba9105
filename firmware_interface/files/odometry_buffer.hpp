#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "firmware_interface/files/stamped_pose.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// Odometry samples in the order of their stamps, asked for the pose at any stamp between them.
///
/// Filled at once from a file or sample by sample. One owner at a time; queries do not allocate.
class OdometryBuffer {
 public:
  /// How far samples are trusted to speak for stamps they were not taken at.
  struct Limits {
    /// Nothing is interpolated between samples further apart than this.
    Duration max_gap;
    /// How far past the first and the last sample the velocity is taken as constant.
    Duration max_extrapolation;
  };

  /// Why a span of time is not covered, in the order a caller can do something about it.
  enum class Coverage {
    kCovered,
    kTooLate,   ///< reaches past the last sample: wait, a sample may still come
    kTooEarly,  ///< begins before the first sample
    kGap,       ///< the samples around it lie too far apart
  };

  OdometryBuffer() = default;
  /// @param samples sorted by stamp, stamps unique, as read_tum gives them
  explicit OdometryBuffer(std::vector<StampedPose> samples) : samples_(std::move(samples)) {}

  /// Appends a sample; one with the newest stamp again takes its place. Declines, returning false,
  /// a sample that is older than the newest or not finite.
  bool try_push(const StampedPose& sample);

  /// Forgets samples that no stamp from `stamp` on needs. Amortised O(1) a sample.
  void forget_before(SensorTime stamp);

  [[nodiscard]] std::span<const StampedPose> samples() const {
    return std::span(samples_).subspan(num_forgotten_);
  }

  /// The pose T_O_B at a stamp: interpolated between its neighbours, beyond the ends continued at
  /// the velocity over the end's nearest 50 ms or more (at rest where there is only one sample).
  /// O(log samples).
  /// @return nothing when that would go past the limits
  [[nodiscard]] std::optional<Pose> at(SensorTime stamp, const Limits& limits) const;

  /// Fills `poses` with what is needed to place everything measured in [begin, end], begin <= end:
  /// the poses at both ends and the samples between them, as T_O_B in place of PoseSample::T_R_L;
  /// the caller brings them to its own frames.
  /// @param max_samples at least 2; of more samples in the span every k-th is kept, and both ends
  /// @param poses cleared first; empty unless the span is covered. Does not grow past `max_samples`
  /// @return kCovered, or why not. An end extrapolated within its limit counts as covered.
  Coverage cover(SensorTime begin, SensorTime end, const Limits& limits, std::size_t max_samples,
                 std::vector<PoseSample>& poses) const;

 private:
  std::vector<StampedPose> samples_;
  std::size_t num_forgotten_ = 0;  ///< samples at the front that are not in use any more
};

}  // namespace cloister
