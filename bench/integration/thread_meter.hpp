#pragma once

#include <cstdint>
#include <optional>

namespace cloister {

/// What the cycles of a stretch are.
enum class CycleKind : std::uint8_t {
  kNone,       ///< nothing counts them here
  kCore,       ///< of the core, in user mode, by the processor's own counter
  kReference,  ///< the thread's CPU time in periods of the processor's time stamp counter
};

/// What the calling thread spent between two instants.
struct Spent {
  std::int64_t cpu_ns = 0;
  std::optional<std::int64_t> cycles;  ///< nothing for CycleKind::kNone
  std::int64_t page_faults = 0;        ///< minor ones: memory touched for the first time
  std::int64_t allocations = 0;        ///< as AllocationCounts has them
};

/// Measures stretches of the thread that made it. Cycles are the core's where the system lets programs count them; virtual
/// machines and locked-down systems do not. There, on x86, they are those of the time stamp counter, which runs at the
/// processor's nominal rate, whatever the core's own rate is; the rate is measured for some milliseconds at construction.
class ThreadMeter {
 public:
  ThreadMeter();
  ~ThreadMeter();
  ThreadMeter(const ThreadMeter&) = delete;
  ThreadMeter& operator=(const ThreadMeter&) = delete;

  void start();
  [[nodiscard]] Spent stop();
  [[nodiscard]] CycleKind cycle_kind() const {
    return cycles_file_ >= 0       ? CycleKind::kCore
           : reference_per_ns_ > 0 ? CycleKind::kReference
                                   : CycleKind::kNone;
  }

 private:
  [[nodiscard]] Spent now() const;

  int cycles_file_ = -1;
  double reference_per_ns_ = 0;  ///< periods of the time stamp counter; 0 where it is not asked
  Spent start_;
};

}  // namespace cloister
