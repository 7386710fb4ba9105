#pragma once

#include <optional>
#include <string>

#include "mapping/core/config_fields.hpp"

namespace cloister {

/// Threads and queues.
struct RuntimeConfig {
  int overlap_workers = 1;       ///< threads that compare pairs of submaps
  int scan_queue = 8;            ///< scans that may wait for the integration thread
  int graph_queue = 256;         ///< graph revisions that may be under way
  double fusion_reserve = 0.25;  ///< share of the voxel pools that is kept for fusions
  int vector_bits = 0;           ///< widest vectors to compute with, 0 = whatever the processor has
};

/// All that can be configured.
struct ProgramConfig {
  Config map;
  RuntimeConfig runtime;
};

/// Calls `visit(name, field, least, most)` for every field of the program's configuration.
template <typename ProgramConfigType, typename Visitor>
void visit_program_fields(ProgramConfigType& config, Visitor&& visit) {
  visit_fields(config.map, visit);
  visit("runtime.overlap_workers", config.runtime.overlap_workers, 1, 256);
  visit("runtime.scan_queue", config.runtime.scan_queue, 2, 1024);
  visit("runtime.graph_queue", config.runtime.graph_queue, 2, 65536);
  visit("runtime.fusion_reserve", config.runtime.fusion_reserve, 0.0, 0.9);
  visit("runtime.vector_bits", config.runtime.vector_bits, 0, 512);
}

}  // namespace cloister
