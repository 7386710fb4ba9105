#include "bench/support/allocation_counter.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include <sys/mman.h>
#include <sys/syscall.h>

namespace cloister {
namespace {

static_assert(std::atomic<std::int64_t>::is_always_lock_free, "other processes read it");

constinit AllocationCounts g_own_places[kMaxCountedThreads];
constinit std::atomic<std::size_t> g_num_taken{0};
// Not the default model: that one may call malloc.
thread_local constinit AllocationCounts* t_counts __attribute__((tls_model("initial-exec"))) =
    nullptr;

/// Where the counts are kept. Allocates nothing: it is called by malloc.
AllocationCounts* find_places() {
  const char* const file = std::getenv(kAllocationFileVariable);
  if (file == nullptr) return g_own_places;
  const int fd = open(file, O_RDWR | O_CLOEXEC);
  if (fd < 0) return g_own_places;
  void* const places =
      mmap(nullptr, sizeof(g_own_places), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  return places == MAP_FAILED ? g_own_places : static_cast<AllocationCounts*>(places);
}

}  // namespace

AllocationCounts& thread_allocation_counts() {
  if (t_counts == nullptr) {
    static AllocationCounts* const places = find_places();
    t_counts = &places[std::min(g_num_taken.fetch_add(1), kMaxCountedThreads - 1)];
    t_counts->thread_id = static_cast<std::int32_t>(syscall(SYS_gettid));
  }
  return *t_counts;
}

}  // namespace cloister

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// Sums that nothing else hangs on: relaxed order is enough.
void count_allocation() {
  cloister::thread_allocation_counts().allocations.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  count_allocation();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  count_allocation();
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  count_allocation();
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count_allocation();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result != nullptr ? 0 : ENOMEM;
}
void free(void* memory) {
  if (memory == nullptr) return;
  cloister::thread_allocation_counts().frees.fetch_add(1, std::memory_order_relaxed);
  __libc_free(memory);
}
}

#endif
