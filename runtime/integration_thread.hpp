#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "mapping/submap/local_mapper.hpp"
#include "runtime/doorbell.hpp"
#include "runtime/lent_threads.hpp"
#include "runtime/messages.hpp"
#include "runtime/spsc_queue.hpp"

namespace cloister {

/// Bytes and number of the submaps that are not active, kept by both threads that change them.
struct FinishedTotals {
  std::atomic<std::int64_t> bytes{0};
  std::atomic<std::int32_t> count{0};
};

/// What connects the integration thread to the others. Each queue's ends are named from its point of view.
struct IntegrationPorts {
  SpscQueue<IntegrationCommand>& commands;  ///< from the reader
  SpscQueue<MapReturn>& returns;            ///< from the fusion scheduler
  SpscQueue<ScanReport>& reports;           ///< to the reader; never full: one place for each scan slot
  SpscQueue<SchedulerCommand>& scheduler;   ///< to the fusion scheduler; never full for submaps: one place each
  Doorbell& bell;                           ///< rung by whoever queues something for this thread
  Doorbell& scheduler_bell;
  Doorbell& reader_bell;
  FinishedTotals& finished;
  LentThreads* workers = nullptr;           ///< whose CPU time is integration's as well
};

/// The thread that integrates scans. Between its start and its end it makes no allocation, takes no lock and does no
/// I/O; it sleeps only when all its queues are empty.
class IntegrationThread {
 public:
  /// @param on_start  called on the new thread before anything else (affinity, priority, a test's allocation guard)
  IntegrationThread(LocalMapper& mapper, const IntegrationPorts& ports, std::function<void()> on_start);
  ~IntegrationThread();

  /// Commands completed so far. Acquire: who reads it sees what they did.
  [[nodiscard]] std::uint64_t num_done() const { return num_done_.load(std::memory_order_acquire); }
  /// Commands given to the scheduler so far. Meaningful while this thread is idle.
  [[nodiscard]] std::uint64_t num_handed_over() const { return num_handed_over_.load(std::memory_order_acquire); }
  /// Puts the thread before all that has no priority in real time (SCHED_FIFO). False when that is not permitted.
  [[nodiscard]] bool raise_priority(int priority);
  /// Closes the active submap, hands it to the scheduler, and ends the thread. Queue nothing afterwards.
  void stop();

 private:
  void run();
  void take_returns();
  void handle(const ScanJob& job);
  void handle(const GraphRevision* revision);
  void hand_over(Submap* finished, SensorTime stamp, const GraphRevision* revision);

  LocalMapper& mapper_;
  IntegrationPorts ports_;
  SensorTime now_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> num_done_{0};
  std::atomic<std::uint64_t> num_handed_over_{0};
  std::thread thread_;
};

}  // namespace cloister
