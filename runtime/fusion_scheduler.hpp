#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "mapping/fuse/elastic_map.hpp"
#include "mapping/record/mission_record.hpp"
#include "runtime/cpu_clock.hpp"
#include "runtime/doorbell.hpp"
#include "runtime/integration_thread.hpp"
#include "runtime/messages.hpp"
#include "runtime/spsc_queue.hpp"

namespace cloister {

/// What connects the fusion scheduler to the others.
struct SchedulerPorts {
  SpscQueue<SchedulerCommand>& commands;  ///< from the integration thread
  SpscQueue<MapReturn>& returns;  ///< to the integration thread; what does not fit waits here
  SpscQueue<const GraphRevision*>& retired;  ///< to the reader: revisions that nobody uses any more
  SpscQueue<OverlapBatch*>& requests;        ///< to the overlap worker
  SpscQueue<OverlapBatch*>& answers;         ///< from the overlap worker
  Doorbell& bell;
  Doorbell& worker_bell;
  Doorbell& integration_bell;
  Doorbell& reader_bell;
  FinishedTotals& finished;
};

/// What the scheduler has counted and decided; read it after the thread has ended, or while it is idle.
struct SchedulerRecord {
  std::vector<Event> events;
  std::vector<float> overlap_ms, fuse_ms, uncertainty_ms;
  std::int64_t cpu_fusion_ns = 0, cpu_uncertainty_ns = 0;
  std::int64_t proposed_by_loop = 0, proposed_by_overlap = 0, accepted = 0,
               rejected_by_uncertainty = 0, rejected_by_overlap = 0, declined_by_memory = 0,
               lost_roots = 0, blocks_shared = 0;
};

/// The thread that owns the finished submaps: it moves them when the graph changes, has pairs compared, asks the graph
/// how certain it is, and fuses.
class FusionScheduler {
 public:
  /// @param max_submaps  slots there are; the returns queue must have more places
  FusionScheduler(ElasticMap& map, double fusion_reserve, std::size_t max_submaps,
                  const SchedulerPorts& ports);
  ~FusionScheduler();

  /// Commands completed so far. Acquire: who reads it sees what they did.
  [[nodiscard]] std::uint64_t num_done() const { return num_done_.load(std::memory_order_acquire); }
  /// Completes what is queued and ends the thread.
  void stop();
  [[nodiscard]] const SchedulerRecord& record() const { return record_; }

 private:
  void run();
  void handle(const SchedulerCommand& command);
  void fuse_all(SensorTime stamp);
  void share_places();
  void absorb_remnants(SensorTime stamp);
  void compare(std::vector<PairCheck> checks, SensorTime stamp);
  [[nodiscard]] Judgement judge(const FusionCandidate& candidate);
  void decide(const FusionCandidate& candidate, SensorTime stamp);
  /// Does what `event` says by `fusion`, which returns the slot that it emptied, or null; and accounts for it.
  template <typename Fusion>
  [[nodiscard]] bool fuse(Event& event, const StopWatch& watch, Fusion&& fusion);
  void send_surplus();
  void push(const MapReturn& item);

  ElasticMap& map_;
  SchedulerPorts ports_;
  std::size_t reserve_blocks_;
  std::size_t reserve_chunks_;
  std::size_t kept_places_;  ///< of the returns queue, for slots
  const GraphRevision* revision_ = nullptr;
  OverlapBatch batch_;
  SchedulerRecord record_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> num_done_{0};
  std::thread thread_;
};

}  // namespace cloister
