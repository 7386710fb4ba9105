#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "runtime/doorbell.hpp"
#include "runtime/lent_threads.hpp"
#include "runtime/messages.hpp"
#include "runtime/spsc_queue.hpp"

namespace cloister {

/// The thread that compares pairs of submaps, several at a time where there are cores for it. The
/// answers do not depend on how many.
class OverlapWorker {
 public:
  /// @param requests  from the scheduler
  /// @param answers   back to the scheduler, the same batch with its overlaps filled
  OverlapWorker(const VoxelStore& store, double voxel_size_m, int num_threads, SpscQueue<OverlapBatch*>& requests,
                SpscQueue<OverlapBatch*>& answers, Doorbell& bell, Doorbell& scheduler_bell);
  ~OverlapWorker();

  /// CPU time spent on comparisons so far, all threads.
  [[nodiscard]] std::int64_t cpu_ns() const { return cpu_ns_.load(std::memory_order_relaxed); }

 private:
  void run();
  void compare(OverlapBatch& batch);

  const VoxelStore& store_;
  double voxel_size_m_;
  LentThreads workers_;
  SpscQueue<OverlapBatch*>& requests_;
  SpscQueue<OverlapBatch*>& answers_;
  Doorbell& bell_;
  Doorbell& scheduler_bell_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> cpu_ns_{0};
  std::thread thread_;
};

}  // namespace cloister
