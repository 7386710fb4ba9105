#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "bench/integration/placed_scan.hpp"
#include "firmware_interface/files/odometry_buffer.hpp"
#include "firmware_interface/mission/mission_reader.hpp"

namespace cloister {

/// Whose poses place the scans.
enum class PoseSource { kAuto, kOdometry, kTruth };

/// The scans of a mission in one frame S, without submaps.
///
/// S is parallel to the frame of the poses (W of the truth, O of the odometry, M of the graph for clouds that have no
/// odometry), its origin on that frame's grid of blocks near the first scan.
class MissionScans {
 public:
  /// @param skip  scans to pass over at the beginning
  [[nodiscard]] static Result<MissionScans> open(const std::filesystem::path& mission,
                                                 const Config& config, PoseSource source,
                                                 std::int64_t skip);

  /// The next scan that has a pose, or nothing at the mission's end.
  [[nodiscard]] Result<bool> next(PlacedScan& placed);

  [[nodiscard]] const MissionReader& reader() const { return *reader_; }
  [[nodiscard]] bool uses_truth() const { return truth_.has_value(); }
  /// "truth", "odometry" or "graph".
  [[nodiscard]] const char* pose_source() const { return pose_source_; }
  /// Of S in the frame of the poses; valid once the first scan has been read.
  [[nodiscard]] Eigen::Vector3d origin_A() const {
    return origin_A_.value_or(Eigen::Vector3d::Zero());
  }

 private:
  MissionScans() = default;
  /// Pose of the scan's reference frame among the poses' frame A; the scan's own poses are replaced by the truth's.
  [[nodiscard]] std::optional<Pose> place(Scan& scan);

  Config config_;
  std::unique_ptr<MissionReader> reader_;
  std::unique_ptr<GraphRevision> graph_;
  std::optional<OdometryBuffer> truth_;
  std::optional<Eigen::Vector3d> origin_A_;
  const char* pose_source_ = "odometry";
  std::int64_t skip_ = 0;
};

}  // namespace cloister
