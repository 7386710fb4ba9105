#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/submap/submap_anchors.hpp"
#include "mapping/submap/submap_path.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Submaps are numbered from 0 in the order they were spawned. A fused submap keeps the smaller id.
using SubmapId = std::int32_t;
inline constexpr SubmapId kNoSubmap = -1;

/// A rigid occupancy volume, anchored to a node of the pose graph.
///
/// Its frame S is parallel to M's axes, with its origin on M's grid of blocks, at the time it was spawned; afterwards
/// it moves rigidly with its root node, or, where the graph bends within it, with most of its nodes (see SubmapAnchors).
/// Voxels never move inside S, but for whole voxels when a fusion lays its blocks on M's anew (see ElasticMap::fuse).
///
/// Slots of this type are allocated once; the mapper fills the scalar members and the volume, and whoever keeps the
/// books fills the vectors when the submap is finished.
struct Submap {
  SubmapId id = kNoSubmap;
  NodeId root = kNoNode;         ///< kNoNode while no graph is known: then T_M_S is T_O_S
  SensorTime spawned;            ///< stamp of its first scan
  SubmapId continues = kNoSubmap;  ///< the submap that ended where this one began only for its length: they are one place
  bool is_continued = false;  ///< it ended for its length: another one continues it
  Pose T_root_S = Pose::Identity();
  Pose T_M_S = Pose::Identity(); ///< as of the newest graph revision applied
  NodeId first_node = kNoNode;   ///< lowest and highest node whose scans it holds
  NodeId last_node = kNoNode;
  SubmapAnchors anchors;         ///< what binds it to the graph: the root, and other nodes
  SubmapPath path;               ///< where the sensor was
  Volume volume;

  std::vector<SubmapId> merged_from;  ///< ids that were fused into this one, ascending, without its own
  std::vector<NodeId> nodes;          ///< nodes whose scans it holds, ascending
  std::vector<SensorTime> scan_stamps;

  /// Makes a node the root. No allocation.
  void bind(NodeId node, const Pose& T_node_S);
  /// Notes that scans of a node come now. No allocation.
  void note_scans(NodeId node, const Pose& T_node_S);
  /// Extends the range of nodes; kNoNode is ignored. No allocation.
  void note_node(NodeId node);
  /// S becomes another frame: all poses and the path are given in it. The volume is the caller's to lay anew.
  /// @param T_S_new  its pose in S so far. No allocation.
  void move_frame(const Pose& T_S_new);
  /// Makes an unused slot of this one. The volume must have been cleared.
  void reset();
};

/// Moves the submap to where a graph revision puts its nodes. A submap without a root is bound to the node nearest in
/// time to its first scan whose odometry is known. A revision that has none of its nodes leaves the submap in place.
/// @return false when the root is missing from the revision
/// No allocation; O(anchors log nodes), O(nodes) for the first binding.
bool apply_graph(Submap& submap, const GraphRevision& revision);

}  // namespace cloister
