#include "firmware_interface/mission/graph_keeper.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace cloister {
namespace {

bool by_id(const GraphNode& a, const GraphNode& b) { return a.id < b.id; }

bool is_same_measurement(const GraphEdge& a, const GraphEdge& b) {
  return a.from == b.from && a.to == b.to && a.T_from_to.matrix() == b.T_from_to.matrix();
}

}  // namespace

GraphCause GraphKeeper::check(const GraphUpdate& update) const {
  if (has_session_ && update.session != session_) return GraphCause::kOtherSession;
  if (update.revision <= revision_) return GraphCause::kRepeated;
  if (update.base_revision != 0 && update.base_revision != revision_)
    return GraphCause::kOutOfOrder;
  if (update.base_revision == 0 && update.graph.nodes.empty()) return GraphCause::kMalformed;
  for (const GraphNode& node : update.graph.nodes) {
    if (node.id < 0 || !is_finite(node.T_M_N)) return GraphCause::kMalformed;
  }
  return GraphCause::kApplied;
}

GraphCause GraphKeeper::apply(const GraphUpdate& update) {
  const auto refuse = [&](GraphCause cause) {
    counters_.add(cause);
    return cause;
  };
  if (const GraphCause cause = check(update); cause != GraphCause::kApplied) return refuse(cause);

  PoseGraph next;
  next.stamp = update.graph.stamp;
  next.nodes = update.graph.nodes;
  std::stable_sort(next.nodes.begin(), next.nodes.end(), by_id);
  const auto twin =
      std::adjacent_find(next.nodes.begin(), next.nodes.end(),
                         [](const GraphNode& a, const GraphNode& b) { return a.id == b.id; });
  if (twin != next.nodes.end()) return refuse(GraphCause::kMalformed);
  if (update.base_revision != 0) {
    // Of a node in both, the update's comes first and stays.
    std::vector<GraphNode> merged;
    std::set_union(next.nodes.begin(), next.nodes.end(), graph_.nodes.begin(), graph_.nodes.end(),
                   std::back_inserter(merged), by_id);
    next.nodes = std::move(merged);
    next.edges = graph_.edges;
  }
  const std::size_t num_base_edges = next.edges.size();
  for (const GraphEdge& edge : update.graph.edges) add_edge(edge, num_base_edges, next);

  graph_ = std::move(next);
  session_ = update.session;
  has_session_ = true;
  revision_ = update.revision;
  counters_.add(GraphCause::kApplied);
  return GraphCause::kApplied;
}

void GraphKeeper::add_edge(const GraphEdge& edge, std::size_t num_base_edges, PoseGraph& graph) {
  if (edge.from == edge.to || !is_finite(edge.T_from_to) ||
      (edge.has_information && !edge.information.allFinite())) {
    counters_.add(GraphCause::kEdgeMalformed);
    return;
  }
  if (graph.find(edge.from) < 0 || graph.find(edge.to) < 0) {
    counters_.add(GraphCause::kEdgeOfUnknownNode);
    return;
  }
  // An increment may send an edge again. Within one update, parallel edges are two measurements.
  const auto end_of_base = graph.edges.begin() + static_cast<std::ptrdiff_t>(num_base_edges);
  const auto known = std::find_if(graph.edges.begin(), end_of_base, [&](const GraphEdge& other) {
    return is_same_measurement(edge, other);
  });
  GraphEdge added = edge;
  if (!edge.has_information) {
    counters_.add(GraphCause::kEdgeWithoutInformation);
    if (!(default_information_ > 0)) return;
    added.information = default_information_ * Matrix6d::Identity();
  }
  if (known != end_of_base) {
    *known = added;
  } else {
    graph.edges.push_back(added);
  }
}

}  // namespace cloister
