#pragma once

#include "mapping/graph/graph_revision.hpp"

namespace cloister {

/// Nodes from 0 on in a row along x, 2 m apart, with odometry edges between neighbours.
inline GraphRevision row_of_nodes(double information, NodeId num_nodes = 10) {
  GraphRevision revision;
  for (NodeId id = 0; id < num_nodes; ++id) {
    GraphNode node{id, {id * 1'000'000'000}, true, Pose::Identity()};
    node.T_M_N.translation().x() = 2.0 * static_cast<double>(id);
    revision.graph.nodes.push_back(node);
    revision.T_O_N.emplace_back(node.T_M_N);
    if (id == 0) continue;
    Pose step = Pose::Identity();
    step.translation().x() = 2.0;
    revision.graph.edges.push_back({id - 1, id, step, Matrix6d::Identity() * information, true});
  }
  return revision;
}

/// The same with a true loop closure, the revision's only new one.
inline GraphRevision with_loop(GraphRevision revision, NodeId from, NodeId to, double information) {
  Pose measured = Pose::Identity();
  measured.translation().x() = 2.0 * static_cast<double>(to - from);
  revision.new_loops = {revision.graph.edges.size()};
  revision.graph.edges.push_back({from, to, measured, Matrix6d::Identity() * information, true});
  return revision;
}

}  // namespace cloister
