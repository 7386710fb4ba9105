#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "mapping/fuse/elastic_map.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/scan/scan.hpp"
#include "mapping/submap/local_mapper.hpp"
#include "mapping/submap/submap.hpp"

namespace cloister {

/// A scan on its way to the integration thread.
struct ScanJob {
  Scan* scan = nullptr;                                ///< a slot; comes back in the report
  std::chrono::steady_clock::time_point last_packet;   ///< host clock
};

/// Reader -> integration thread: one of both is set; neither only has it take what has come back.
struct IntegrationCommand {
  ScanJob job;
  const GraphRevision* revision = nullptr;
};

/// Integration thread -> reader: what became of a scan.
struct ScanReport {
  Scan* scan = nullptr;
  ScanOutcome outcome;
  float integrate_ms = 0;
  float latency_ms = 0;
  std::int64_t spawn_check_cpu_ns = 0;
  std::int64_t integration_cpu_ns = 0;
  std::int32_t queue_depth = 0;
  std::int32_t num_submaps = 0;
  std::int64_t map_bytes = 0;
  std::size_t blocks_used = 0;  ///< of the integration thread's share: see PoolShare::num_used
  std::size_t chunks_used = 0;
};

/// Integration thread -> fusion scheduler: a submap that is finished, or a graph revision.
struct SchedulerCommand {
  SensorTime stamp;
  Submap* finished = nullptr;
  const GraphRevision* revision = nullptr;
};

/// Fusion scheduler -> integration thread: memory on its way home.
struct MapReturn {
  Submap* empty_slot = nullptr;
  std::uint32_t num_blocks = 0;
  std::uint32_t num_chunks = 0;
  std::array<PoolIndex, 60> items;     ///< blocks first, then chunks
};

/// Fusion scheduler <-> overlap worker: pairs to compare, lent until they come back.
struct OverlapBatch {
  std::vector<PairCheck> checks;
  std::vector<float> milliseconds;  ///< [checks], wall time each
};

}  // namespace cloister
