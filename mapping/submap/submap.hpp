#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Submaps are numbered from 0 in the order they were spawned. A fused submap keeps the smaller id.
using SubmapId = std::int32_t;
inline constexpr SubmapId kNoSubmap = -1;

/// A rigid occupancy volume, anchored to a node of the pose graph.
///
/// Its frame S is parallel to M's axes, with its origin on M's voxel grid, at the time it was spawned; afterwards it
/// moves rigidly with its root node: T_M_S = T_M_root * T_root_S.
struct Submap {
  SubmapId id = kNoSubmap;
  std::vector<SubmapId> merged_from;  ///< ids that were fused into this one, ascending, without its own
  NodeId root = kNoNode;              ///< kNoNode while no graph is known: then T_root_S is T_O_S
  Pose T_root_S = Pose::Identity();
  Pose T_M_S = Pose::Identity();      ///< as of the newest graph revision
  std::vector<NodeId> nodes;          ///< nodes whose scans it holds, ascending
  std::vector<SensorTime> scan_stamps;
  Volume volume;
};

}  // namespace cloister
