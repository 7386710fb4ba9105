#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "bench/support/allocation_counter.hpp"
#include "firmware_interface/mission/mission_reader.hpp"
#include "runtime/pipeline.hpp"

// Sanitizers bring allocators of their own, so there the counter counts nothing and the cases are left out.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace cloister {
namespace {

TEST_CASE("the guard sees an allocation") {
  const AllocationCounts& counts = thread_allocation_counts();
  const std::int64_t allocations = counts.allocations, frees = counts.frees;
  std::unique_ptr<int> watched = std::make_unique<int>(1);
  CHECK(*watched == 1);
  watched.reset();
  CHECK(counts.allocations - allocations >= 1);
  CHECK(counts.frees - frees >= 1);
}

TEST_CASE("the integration thread allocates nothing in a whole mission with spawns, corrections and fusions") {
  ProgramConfig config;
  config.map.spawn.min_overlap = 0.85;  // many submaps, many fusions
  config.map.fusion.min_active_travel_m = 1;
  auto reader = MissionReader::open(CLOISTER_HOUSE_MISSION, config.map);
  REQUIRE(reader.has_value());
  Pipeline::Options options;
  options.max_scan_pixels = (*reader)->max_pixels();
  options.max_scan_columns = (*reader)->max_columns();
  // One reference: a larger hook would lie on the heap, and be freed by the thread that it is called on.
  struct {
    const AllocationCounts* counts = nullptr;
    std::int64_t allocations = 0, frees = 0;
  } before;
  options.on_integration_start = [&before] {
    before.counts = &thread_allocation_counts();
    before.allocations = before.counts->allocations;
    before.frees = before.counts->frees;
  };
  Pipeline pipeline(config, options);
  Scan next;
  next.reserve(options.max_scan_pixels, options.max_scan_columns, MissionReader::kMaxPoses);
  while (true) {
    const auto item = (*reader)->next(next);
    REQUIRE(item.has_value());
    if (*item == MissionReader::Item::kEnd) break;
    if (*item == MissionReader::Item::kGraph) {
      pipeline.submit((*reader)->take_graph());
      continue;
    }
    pipeline.wait_for_scans(4);
    Scan* slot = pipeline.try_take_slot();
    REQUIRE(slot != nullptr);
    std::swap(*slot, next);
    pipeline.submit(slot);
  }
  pipeline.finish();
  CHECK(pipeline.record().scans_integrated > 140);
  CHECK(pipeline.record().submaps_spawned > 3);
  CHECK(pipeline.record().fusions_accepted > 0);
  REQUIRE(before.counts != nullptr);
  CHECK(before.counts->allocations == before.allocations);
  // std::thread frees its own start function when the thread ends.
  CHECK(before.counts->frees - before.frees <= 1);
}

}  // namespace
}  // namespace cloister

#endif
