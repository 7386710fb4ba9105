#include <algorithm>
#include <cstdint>
#include <utility>

#include <doctest/doctest.h>

#include "firmware_interface/map/map_hash.hpp"
#include "test/support/eager_house.hpp"

namespace cloister {
namespace {

struct Outcome {
  std::uint64_t hash = 0;
  std::int64_t scans = 0, fusions = 0, loop_closures = 0;
};

/// Adds a loop closure from the first node to the newest, as the graph's poses have it: the house is left before it has one.
void close_loop(GraphRevision& revision) {
  const GraphNode& first = revision.graph.nodes.front();
  const GraphNode& newest = revision.graph.nodes.back();
  GraphEdge edge{first.id, newest.id, first.T_M_N.inverse() * newest.T_M_N};
  edge.information *= 1e6;
  if (!edge.is_loop_closure()) return;
  revision.new_loops.push_back(revision.graph.edges.size());
  revision.graph.edges.push_back(edge);
}

/// Maps the house.
/// @param is_lockstep  whether the reader lets the map settle after each graph and each finished submap; else it waits for
///                     nothing but room in the queue
Outcome map_house(bool is_lockstep) {
  EagerHouse house;
  Pipeline pipeline(house.config, house.options);
  while (true) {
    const MissionReader::Item item = house.next();
    if (item == MissionReader::Item::kEnd) break;
    if (is_lockstep) {
      pipeline.wait_for_scans(0);
      if (pipeline.take_submap_finished()) pipeline.drain();
    }
    pipeline.wait_for_scans(4);
    if (item == MissionReader::Item::kGraph) {
      auto revision = house.reader->take_graph();
      close_loop(*revision);
      pipeline.submit(std::move(revision));
      if (is_lockstep) pipeline.drain();
      continue;
    }
    house.submit_scan(pipeline);
  }
  pipeline.finish();
  const MissionRecord& record = pipeline.record();
  const auto is_loop_closure = [](const Event& event) {
    return event.kind == EventKind::kLoopClosure;
  };
  return {map_hash(pipeline.store(), pipeline.submaps()), record.scans_integrated,
          record.fusions_accepted,
          std::count_if(record.events.begin(), record.events.end(), is_loop_closure)};
}

TEST_CASE("scans and graphs that wait for no fusion become the map of lockstep") {
  const Outcome lockstep = map_house(true);
  const Outcome live = map_house(false);
  CHECK(lockstep.fusions > 0);
  CHECK(lockstep.loop_closures > 0);
  CHECK(live.scans == lockstep.scans);
  CHECK(live.fusions == lockstep.fusions);
  CHECK(live.hash == lockstep.hash);
}

}  // namespace
}  // namespace cloister
