#include <doctest/doctest.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>

#include "firmware_interface/mission/mission_reader.hpp"
#include "runtime/pipeline.hpp"

// Counts every allocation of one thread. malloc itself is counted, not operator new: Eigen's heap goes past the latter.
// Sanitizers bring allocators of their own, so there this file counts nothing and the case is left out.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
thread_local bool t_is_watched = false;
std::atomic<std::uint64_t> g_num_allocations{0};
std::atomic<std::uint64_t> g_num_frees{0};
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  if (t_is_watched) g_num_allocations.fetch_add(1);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  if (t_is_watched) g_num_allocations.fetch_add(1);
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  if (t_is_watched) g_num_allocations.fetch_add(1);
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  if (t_is_watched) g_num_allocations.fetch_add(1);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result != nullptr ? 0 : ENOMEM;
}
void free(void* memory) {
  if (t_is_watched && memory != nullptr) g_num_frees.fetch_add(1);
  __libc_free(memory);
}
}

namespace cloister {
namespace {

TEST_CASE("the guard sees an allocation") {
  t_is_watched = true;
  std::unique_ptr<int> watched = std::make_unique<int>(1);
  CHECK(*watched == 1);
  watched.reset();
  t_is_watched = false;
  CHECK(g_num_allocations.exchange(0) >= 1);
  CHECK(g_num_frees.exchange(0) >= 1);
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
  options.on_integration_start = [] { t_is_watched = true; };
  g_num_allocations = 0;
  g_num_frees = 0;
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
  CHECK(g_num_allocations.load() == 0);
  CHECK(g_num_frees.load() <= 1);  // std::thread frees its own start function when the thread ends
}

}  // namespace
}  // namespace cloister

#endif
