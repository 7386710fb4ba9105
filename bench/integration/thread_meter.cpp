#include "bench/integration/thread_meter.hpp"

#include <time.h>
#include <unistd.h>

#include <linux/perf_event.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include "bench/support/allocation_counter.hpp"

namespace cloister {
namespace {

/// A counter of this thread's cycles in user mode, or -1: virtual machines and locked-down systems have none.
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

}  // namespace

ThreadMeter::ThreadMeter() : cycles_file_(open_cycle_counter()) {}

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
  spent.page_faults -= start_.page_faults;
  spent.allocations -= start_.allocations;
  return spent;
}

}  // namespace cloister
