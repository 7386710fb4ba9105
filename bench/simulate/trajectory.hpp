#pragma once

#include <filesystem>
#include <vector>

#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// Poses T_A_L of a sensor L in some frame A at a steady rate.
struct Trajectory {
  SensorTime start;
  Duration step{10'000'000};
  std::vector<Pose> poses;  ///< poses[k] at start + k * step; not empty

  [[nodiscard]] SensorTime stamp(std::size_t k) const {
    return {start.ns + static_cast<std::int64_t>(k) * step.ns};
  }
  [[nodiscard]] SensorTime end() const { return stamp(poses.size() - 1); }
  /// The pose at a stamp, interpolated; the first or last one outside.
  [[nodiscard]] Pose at(SensorTime stamp) const;
  /// Drops all poses after a stamp (the first one stays).
  void cut_after(SensorTime stamp);
};

/// `sec.nsec` with nine decimals, so that no stamp is lost in a double.
[[nodiscard]] std::string format_seconds(SensorTime stamp);

/// A TUM trajectory as text: `t x y z qx qy qz qw`, one pose a line.
[[nodiscard]] std::string format_tum(const Trajectory& trajectory);

/// A pose and when it was.
struct StampedPose {
  SensorTime stamp;
  Pose pose = Pose::Identity();
};

/// Reads `t x y z qx qy qz qw` lines with rising stamps; `#` starts a comment. Errors: kInput with
/// file and line.
[[nodiscard]] Result<std::vector<StampedPose>> read_tum(const std::filesystem::path& path);

/// The pose at a stamp, interpolated between neighbours; the first or last one outside. Rising
/// stamps, not empty.
[[nodiscard]] Pose pose_at(const std::vector<StampedPose>& poses, SensorTime stamp);

}  // namespace cloister
