#include "mapping/submap/submap.hpp"

#include <algorithm>
#include <cstdlib>

#include "mapping/core/config.hpp"

namespace cloister {

static_assert(sizeof(Submap) <= kMaxSubmapSlotBytes);

void Submap::bind(NodeId node, const Pose& T_node_S) {
  root = node;
  T_root_S = T_node_S;
  note_scans(node, T_node_S);
}

void Submap::note_scans(NodeId node, const Pose& T_node_S) {
  note_node(node);
  anchors.add(node, T_node_S);
}

void Submap::note_node(NodeId node) {
  if (node == kNoNode) return;
  first_node = first_node == kNoNode ? node : std::min(first_node, node);
  last_node = std::max(last_node, node);
}

void Submap::move_frame(const Pose& T_S_new) {
  T_root_S = T_root_S * T_S_new;
  T_M_S = T_M_S * T_S_new;
  anchors.move_frame(T_S_new);
  path.move_frame(T_S_new);
}

void Submap::reset() {
  id = continues = kNoSubmap;
  is_continued = false;
  root = first_node = last_node = kNoNode;
  spawned = {};
  T_root_S = T_M_S = Pose::Identity();
  anchors.clear();
  path.clear();
  merged_from.clear();
  nodes.clear();
  scan_stamps.clear();
}

bool apply_graph(Submap& submap, const GraphRevision& revision) {
  if (submap.root == kNoNode) {
    const auto& nodes = revision.graph.nodes;
    std::ptrdiff_t nearest = -1;
    std::int64_t nearest_ns = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!revision.T_O_N[i]) continue;
      const std::int64_t distance_ns = std::abs((nodes[i].stamp - submap.spawned).ns);
      if (nearest >= 0 && distance_ns >= nearest_ns) continue;
      nearest = static_cast<std::ptrdiff_t>(i);
      nearest_ns = distance_ns;
    }
    if (nearest < 0) return false;
    submap.bind(nodes[nearest].id, revision.T_O_N[nearest]->inverse() * submap.T_M_S);
  }
  const std::optional<Pose> T_M_S = submap.anchors.fit(revision);
  if (T_M_S) submap.T_M_S = *T_M_S;
  return revision.node(submap.root) != nullptr;
}

}  // namespace cloister
