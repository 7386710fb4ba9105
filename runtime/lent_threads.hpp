#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "mapping/integrate/shared_scan.hpp"

namespace cloister {

/// oneTBB's threads, lent to another thread: to the integration thread for its scans, to the overlap worker for its pairs.
///
/// Threads: one caller. oneTBB allocates when its threads first meet a task; where nothing may allocate, there is one worker,
/// the caller, and none of this is used.
class LentThreads : public ScanWorkers {
 public:
  explicit LentThreads(int num);
  ~LentThreads() override;

  [[nodiscard]] int num() const override { return num_; }
  void run(void (*task)(void* context, int worker), void* context) override;

  /// CPU time of all threads but the caller's, since this was last asked.
  [[nodiscard]] std::int64_t take_cpu_ns() {
    return cpu_ns_.exchange(0, std::memory_order_relaxed);
  }

 private:
  struct Arena;

  int num_;
  std::unique_ptr<Arena> arena_;
  std::atomic<std::int64_t> cpu_ns_{0};  ///< a sum that only the reports read
};

}  // namespace cloister
