#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

using NodeId = std::int64_t;

/// Marks "no node" where a NodeId is optional.
inline constexpr NodeId kNoNode = -1;

/// A 6x6 matrix over (translation [m], rotation vector [rad]), in that order.
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// One pose of the SLAM system's graph.
struct GraphNode {
  NodeId id = kNoNode;
  SensorTime stamp;      ///< when the sensor was there; 0 when the file had no stamp and no sidecar
  bool has_stamp = false;
  Pose T_M_N = Pose::Identity();
};

/// A measured relative pose between two nodes.
struct GraphEdge {
  NodeId from = kNoNode;
  NodeId to = kNoNode;
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Identity();  ///< of the error (translation, rotation vector), full matrix
  bool has_information = true;  ///< false: the file had none, and a default stands in its place

  /// An edge between nodes that do not follow each other.
  [[nodiscard]] bool is_loop_closure() const { return from - to > 1 || to - from > 1; }
};

/// The whole graph as it stood at one stamp. Nodes are sorted by id and ids are unique; every edge names two
/// different nodes that exist.
struct PoseGraph {
  SensorTime stamp;  ///< when the SLAM system published it
  std::vector<GraphNode> nodes;
  std::vector<GraphEdge> edges;

  /// Position of the node in `nodes`, or -1. O(log nodes).
  [[nodiscard]] std::ptrdiff_t find(NodeId id) const;
};

}  // namespace cloister
