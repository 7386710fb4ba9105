#pragma once

#include <cstdint>
#include <optional>

namespace cloister {

/// What the calling thread spent between two instants.
struct Spent {
  std::int64_t cpu_ns = 0;
  std::optional<std::int64_t> cycles;  ///< user mode; nothing where the system does not count them
  std::int64_t page_faults = 0;        ///< minor ones: memory touched for the first time
  std::int64_t allocations = 0;        ///< as AllocationCounts has them
};

/// Measures stretches of the thread that made it.
class ThreadMeter {
 public:
  ThreadMeter();
  ~ThreadMeter();
  ThreadMeter(const ThreadMeter&) = delete;
  ThreadMeter& operator=(const ThreadMeter&) = delete;

  void start();
  [[nodiscard]] Spent stop();
  [[nodiscard]] bool counts_cycles() const { return cycles_file_ >= 0; }

 private:
  [[nodiscard]] Spent now() const;

  int cycles_file_ = -1;
  Spent start_;
};

}  // namespace cloister
