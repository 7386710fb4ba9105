#pragma once

#include <span>
#include <vector>

#include "bench/simulate/trajectory.hpp"
#include "mapping/core/pose.hpp"

namespace cloister {

/// How the map lies in the world, and how well the trajectories agree once it does.
struct Alignment {
  Pose T_W_M = Pose::Identity();
  double rms_m = 0.0;  ///< of the positions, after alignment
  double max_m = 0.0;
};

/// The rigid motion that brings estimated poses nearest to the true ones: least squares (Umeyama 1991, without scale)
/// over each pose's origin and the tips of its axes, one metre long, so that a mission that hardly moves is aligned too.
/// @param T_M_L estimated poses, not empty @param T_W_L true poses, looked up at the estimates' stamps
[[nodiscard]] Alignment align(std::span<const StampedPose> T_M_L,
                              const std::vector<StampedPose>& T_W_L);

/// Takes the SLAM system's error out of places, each by the scans that were taken near it. One rigid motion for all leaves
/// decimetres of it, by which a map that is right within itself lies beside the truth.
class LocalAlignment {
 public:
  /// @param T_M_L estimated poses, not empty @param T_W_L true poses, looked up at the estimates' stamps
  LocalAlignment(std::span<const StampedPose> T_M_L, const std::vector<StampedPose>& T_W_L);

  /// Where the scans near a place would have put it, had the graph been right about them: each scan's rigid correction,
  /// weighed by how near to the place the scan was taken (5 m count as a standard deviation). Threads: any number.
  [[nodiscard]] Eigen::Vector3d to_world(const Eigen::Vector3d& p_M) const;

 private:
  struct Correction {
    Eigen::Vector3d at_M;
    Pose T_W_M;
  };
  std::vector<Correction> corrections_;  ///< one every half metre of the way
};

}  // namespace cloister
