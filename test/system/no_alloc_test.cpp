#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "bench/support/allocation_counter.hpp"
#include "test/support/eager_house.hpp"

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
  EagerHouse house;
  // One reference: a larger hook would lie on the heap, and be freed by the thread that it is called on.
  struct {
    const AllocationCounts* counts = nullptr;
    std::int64_t allocations = 0, frees = 0;
  } before;
  house.options.on_integration_start = [&before] {
    before.counts = &thread_allocation_counts();
    before.allocations = before.counts->allocations;
    before.frees = before.counts->frees;
  };
  Pipeline pipeline(house.config, house.options);
  while (true) {
    const MissionReader::Item item = house.next();
    if (item == MissionReader::Item::kEnd) break;
    if (item == MissionReader::Item::kGraph) {
      pipeline.submit(house.reader->take_graph());
      continue;
    }
    pipeline.wait_for_scans(4);
    house.submit_scan(pipeline);
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
