#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// A pose graph as it reaches the mapper: immutable, shared by reference, and completed by what the odometry said.
struct GraphRevision {
  std::uint64_t revision = 0;             ///< counts from 1
  PoseGraph graph;
  std::vector<std::optional<Pose>> T_O_N; ///< [graph.nodes] odometry at each node's stamp, where it is known
  std::vector<std::size_t> new_loops;     ///< positions in graph.edges of loop closures the last revision did not have

  [[nodiscard]] const GraphNode* node(NodeId id) const {
    const std::ptrdiff_t position = graph.find(id);
    return position < 0 ? nullptr : &graph.nodes[static_cast<std::size_t>(position)];
  }
};

}  // namespace cloister
