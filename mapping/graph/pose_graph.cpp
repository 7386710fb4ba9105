#include "mapping/graph/pose_graph.hpp"

#include <algorithm>

namespace cloister {

std::ptrdiff_t PoseGraph::find(NodeId id) const {
  const auto it = std::lower_bound(nodes.begin(), nodes.end(), id,
                                   [](const GraphNode& node, NodeId wanted) { return node.id < wanted; });
  return it != nodes.end() && it->id == id ? it - nodes.begin() : -1;
}

}  // namespace cloister
