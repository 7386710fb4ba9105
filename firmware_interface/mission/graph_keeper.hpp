#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware_interface/ouster/counters.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// A pose graph on its way from a SLAM system: all of it, or what changed since the revision before.
struct GraphUpdate {
  std::uint64_t session = 0;  ///< one run of the SLAM system: ids and poses of another mean nothing
  std::uint64_t revision = 0;  ///< counts from 1
  std::uint64_t base_revision =
      0;            ///< 0: the whole graph; else nodes and edges that are new or moved since then
  PoseGraph graph;  ///< nodes and edges in any order, unchecked
};

/// What became of graph updates and their edges.
enum class GraphCause {
  kApplied,
  kRepeated,
  kOutOfOrder,
  kOtherSession,
  kMalformed,
  kEdgeOfUnknownNode,
  kEdgeMalformed,
  kEdgeWithoutInformation,
  kCount,
};

constexpr std::array<CounterName, 8> counter_names(GraphCause) {
  return {{{"graph_updates"},
           {"graph_repeated", true},       // this revision or a newer one is known
           {"graph_out_of_order", true},   // builds on a revision that is not the newest one here
           {"graph_other_session", true},  // of another run of the SLAM system
           {"graph_malformed", true},  // without nodes, one of them twice, or one that is nowhere
           {"graph_edges_of_unknown_nodes", true},
           {"graph_edges_malformed", true},
           {"graph_edges_without_information"}}};
}

/// Keeps the newest pose graph out of the updates that arrive, and refuses what does not fit: a whole graph replaces
/// the one before, an increment must build on it. After a refused increment the next whole graph helps.
///
/// Threads: one at a time. Allocates.
class GraphKeeper {
 public:
  /// @param default_information  stands in for missing information matrices; 0: edges without one are left out
  explicit GraphKeeper(double default_information) : default_information_(default_information) {}

  /// @return kApplied, or why the update was refused; the graph is then as before
  GraphCause apply(const GraphUpdate& update);

  /// As mapping wants it: sorted, ids unique, every edge between two nodes that exist.
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  [[nodiscard]] const Counters<GraphCause>& counters() const { return counters_; }

 private:
  [[nodiscard]] GraphCause check(const GraphUpdate& update) const;
  void add_edge(const GraphEdge& edge, std::size_t num_base_edges, PoseGraph& graph);

  double default_information_;
  bool has_session_ = false;
  std::uint64_t session_ = 0;
  std::uint64_t revision_ = 0;
  PoseGraph graph_;
  Counters<GraphCause> counters_;
};

}  // namespace cloister
