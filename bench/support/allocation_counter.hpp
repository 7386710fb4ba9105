#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace cloister {

/// How often a thread has asked for heap memory, and given it back, since it began. malloc itself is counted, not operator
/// new: Eigen's heap goes past the latter. Nothing is counted under sanitizers, which bring allocators of their own.
struct AllocationCounts {
  std::atomic<std::int32_t> thread_id{0};  ///< as in /proc; 0: a place that no thread has taken
  std::atomic<std::int64_t> allocations{0};
  std::atomic<std::int64_t> frees{0};
};

/// Threads that are counted one by one; those beyond share the last place.
inline constexpr std::size_t kMaxCountedThreads = 256;

/// A program that has the counter put before it (LD_PRELOAD) keeps its counts in the file that this variable names, if it
/// does: kMaxCountedThreads places of AllocationCounts, for others to look into.
inline constexpr const char* kAllocationFileVariable = "CLOISTER_ALLOCATION_FILE";

/// Those of the calling thread.
[[nodiscard]] AllocationCounts& thread_allocation_counts();

}  // namespace cloister
