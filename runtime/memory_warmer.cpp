#include "runtime/memory_warmer.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdint>

#include <sys/mman.h>

namespace cloister {
namespace {

// A scan outdoors asks for a few megabytes at most, and ten scans pass until the reader looks again.
constexpr std::size_t kAheadBytes = 32 << 20;
constexpr std::size_t kHugePageBytes = 2 << 20;

/// Page that holds an address, or the next one's beginning.
std::byte* page_at(std::byte* address, std::size_t page_bytes) {
  return reinterpret_cast<std::byte*>(reinterpret_cast<std::uintptr_t>(address) / page_bytes *
                                      page_bytes);
}

bool populate(std::byte* begin, std::byte* end) {
#ifdef MADV_POPULATE_WRITE
  const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  std::byte* const first = page_at(begin, page_bytes);
  return end <= first ||
         madvise(first, static_cast<std::size_t>(end - first), MADV_POPULATE_WRITE) == 0;
#else
  return end <= begin;
#endif
}

}  // namespace

MemoryWarmer::MemoryWarmer(VoxelStore& store)
    : blocks_{reinterpret_cast<std::byte*>(&store.block(0)), store.num_blocks() * sizeof(Block)},
      chunks_{reinterpret_cast<std::byte*>(&store.chunk(0)), store.num_chunks() * sizeof(Chunk)} {
  for (Region* region : {&blocks_, &chunks_}) {
    std::byte* const first = page_at(region->begin + kHugePageBytes - 1, kHugePageBytes);
    std::byte* const end = page_at(region->begin + region->bytes, kHugePageBytes);
    // A wish: where it is not granted, small pages do as well.
    if (end > first) (void)madvise(first, static_cast<std::size_t>(end - first), MADV_HUGEPAGE);
    if (region->bytes > 0 && !populate(region->begin, region->begin + 1)) {
      std::fill_n(region->begin, region->bytes, std::byte{0});
      region->resident_bytes = region->bytes;
    }
  }
}

void MemoryWarmer::keep_ahead(std::size_t blocks_used, std::size_t chunks_used) {
  keep_ahead(blocks_, blocks_used * sizeof(Block));
  keep_ahead(chunks_, chunks_used * sizeof(Chunk));
}

void MemoryWarmer::keep_ahead(Region& region, std::size_t used_bytes) {
  if (region.resident_bytes >= region.bytes ||
      used_bytes + kAheadBytes / 2 <= region.resident_bytes)
    return;
  // Never before what is used already: the first items may belong to somebody else, who has no hurry.
  const std::size_t from = std::max(region.resident_bytes, std::min(used_bytes, region.bytes));
  const std::size_t to = std::min(used_bytes + kAheadBytes, region.bytes);
  // Memory that the system refuses is asked for again when it is used.
  (void)populate(region.begin + from, region.begin + to);
  region.resident_bytes = to;
}

}  // namespace cloister
