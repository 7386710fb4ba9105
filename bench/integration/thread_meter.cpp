#include "bench/integration/thread_meter.hpp"

#include <time.h>
#include <unistd.h>

#include <chrono>
#include <cmath>

#include <linux/perf_event.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

#include "bench/support/allocation_counter.hpp"

namespace cloister {
namespace {

/// A counter of this thread's cycles in user mode, or -1 where there is none.
int open_cycle_counter() {
  perf_event_attr attributes{};
  attributes.type = PERF_TYPE_HARDWARE;
  attributes.size = sizeof(attributes);
  attributes.config = PERF_COUNT_HW_CPU_CYCLES;
  attributes.exclude_kernel = 1;
  attributes.exclude_hv = 1;
  return static_cast<int>(
      syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
}

std::optional<std::int64_t> read_counter(int file) {
  std::int64_t count = 0;
  if (file < 0 || read(file, &count, sizeof(count)) != sizeof(count)) return std::nullopt;
  return count;
}

/// Rate of the time stamp counter, measured against the clock; 0 where there is none that counts cycles.
double reference_cycles_per_ns() {
#if defined(__x86_64__)
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kWhile{20};
  const Clock::time_point begin = Clock::now();
  const std::uint64_t first = __rdtsc();
  Clock::time_point end = begin;
  while (end - begin < kWhile) end = Clock::now();
  const std::uint64_t last = __rdtsc();
  return static_cast<double>(last - first) /
         std::chrono::duration<double, std::nano>(end - begin).count();
#else
  return 0;
#endif
}

}  // namespace

ThreadMeter::ThreadMeter()
    : cycles_file_(open_cycle_counter()),
      reference_per_ns_(cycles_file_ < 0 ? reference_cycles_per_ns() : 0) {}

ThreadMeter::~ThreadMeter() {
  if (cycles_file_ >= 0) close(cycles_file_);
}

Spent ThreadMeter::now() const {
  Spent now;
  now.cycles = read_counter(cycles_file_);
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  now.page_faults = usage.ru_minflt;
  now.allocations = thread_allocation_counts().allocations;
  timespec cpu{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
  now.cpu_ns = std::int64_t{cpu.tv_sec} * 1'000'000'000 + cpu.tv_nsec;
  return now;
}

void ThreadMeter::start() { start_ = now(); }

Spent ThreadMeter::stop() {
  Spent spent = now();
  spent.cpu_ns -= start_.cpu_ns;
  if (spent.cycles && start_.cycles) *spent.cycles -= *start_.cycles;
  if (cycle_kind() == CycleKind::kReference) {
    spent.cycles = std::llround(reference_per_ns_ * static_cast<double>(spent.cpu_ns));
  }
  spent.page_faults -= start_.page_faults;
  spent.allocations -= start_.allocations;
  return spent;
}

}  // namespace cloister
