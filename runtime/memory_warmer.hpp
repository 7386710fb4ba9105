#pragma once

#include <cstddef>

#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// Keeps the pools' memory resident a little ahead of where it is used, in huge pages where the system offers them: so
/// the integration thread never waits for a page, and a small map does not occupy its whole budget.
///
/// Where the kernel cannot populate memory on request (before Linux 5.14), all of it is touched at construction.
/// Threads: construct before the store is used; then one thread, any but the one that must not wait.
class MemoryWarmer {
 public:
  explicit MemoryWarmer(VoxelStore& store);

  /// Makes the items behind those resident that were handed out last. @param *_used  one more than the highest index
  /// handed out so far. A system call every few megabytes.
  void keep_ahead(std::size_t blocks_used, std::size_t chunks_used);

 private:
  /// One pool's memory.
  struct Region {
    std::byte* begin = nullptr;
    std::size_t bytes = 0;
    std::size_t resident_bytes = 0;  ///< from `begin`; all up to here has been populated
  };
  void keep_ahead(Region& region, std::size_t used_bytes);

  Region blocks_;
  Region chunks_;
};

}  // namespace cloister
