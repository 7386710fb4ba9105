#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "mapping/fuse/elastic_map.hpp"
#include "mapping/record/mission_record.hpp"
#include "mapping/submap/local_mapper.hpp"
#include "runtime/fusion_scheduler.hpp"
#include "runtime/integration_thread.hpp"
#include "runtime/lent_threads.hpp"
#include "runtime/memory_warmer.hpp"
#include "runtime/overlap_worker.hpp"
#include "runtime/runtime_config.hpp"

namespace cloister {

/// The mapper: three threads, the queues between them, and all memory, taken at construction.
///
///     reader --scans, graphs--> integration thread --finished submaps, graphs--> fusion scheduler <--pairs--> overlap
///       ^                          |         ^                                        |                       worker
///       +---------reports----------+         +---------memory, fused submaps----------+
///
/// The reader is the caller's thread: it fills scan slots, submits them, and collects what became of them.
class Pipeline {
 public:
  struct Options {
    std::size_t max_scan_pixels = 0;   ///< largest scan or cloud
    std::size_t max_scan_columns = 0;
    std::size_t max_scan_poses = 256;
    std::function<void()> on_integration_start;  ///< called on the integration thread, before the first scan
  };

  /// Takes all memory and starts the threads.
  Pipeline(const ProgramConfig& config, const Options& options);
  ~Pipeline();

  // The reader's side. One thread.

  /// An empty scan to fill, or null when all are under way.
  [[nodiscard]] Scan* try_take_slot();
  /// Gives back a slot that is not submitted after all.
  void return_slot(Scan* scan) { free_slots_.push_back(scan); }
  /// Queues a filled slot.
  /// @param last_packet  when its last packet arrived: latency counts from there
  void submit(Scan* scan, std::chrono::steady_clock::time_point last_packet = std::chrono::steady_clock::now());
  /// Notes a scan that was read but could not be submitted.
  void drop(const Scan& scan, const char* cause);
  /// Queues a graph revision; waits only when `graph_queue` revisions are under way.
  void submit(std::unique_ptr<GraphRevision> revision);
  /// Collects finished scans into the record. Returns the number of scans under way.
  std::size_t collect();
  /// Waits until at most `max_under_way` scans are under way.
  void wait_for_scans(std::size_t max_under_way);
  /// Waits until all that was submitted is integrated, compared and fused: the map no longer changes by itself.
  void drain();
  /// Drains, finishes the active submap, fuses what is left to fuse, and ends the threads.
  void finish();

  /// True when the scans collected since the last call closed a submap: lockstep then drains.
  [[nodiscard]] bool take_submap_finished() { return std::exchange(submap_finished_, false); }

  /// Scans and graphs that the integration thread has dealt with.
  [[nodiscard]] std::uint64_t num_done() const { return integration_->num_done(); }
  /// Nothing is under way: drain() will return at once.
  [[nodiscard]] bool is_idle() const;
  /// All submaps, the active one last. Valid after drain() until something is submitted.
  [[nodiscard]] std::vector<const Submap*> present_submaps() const;
  [[nodiscard]] const Submap* active_submap() const { return mapper_.active(); }
  /// How full things are; of the pools, the integration thread's share as of the last scan collected.
  struct Fill {
    std::size_t blocks_used = 0, num_blocks = 0;
    std::size_t chunks_used = 0, num_chunks = 0;
    std::size_t commands_waiting = 0;
  };
  [[nodiscard]] Fill fill() const;

  // The outcome. After finish().
  [[nodiscard]] std::vector<const Submap*> submaps() const { return map_.submaps(); }
  [[nodiscard]] const VoxelStore& store() const { return store_; }
  [[nodiscard]] const MissionRecord& record() const { return record_; }
  [[nodiscard]] MissionRecord& record() { return record_; }

 private:
  struct PlacedScan {
    SensorTime stamp;
    NodeId node = kNoNode;
    SubmapId submap = kNoSubmap;
    Pose T_R_L = Pose::Identity();
  };

  void note(const ScanReport& report);
  void reclaim_revisions();
  [[nodiscard]] Pose final_pose(const PlacedScan& placed) const;
  void complete_record();

  ProgramConfig config_;
  VoxelStore store_;
  MemoryWarmer warmer_;
  LentThreads workers_;
  LocalMapper mapper_;
  ElasticMap map_;
  std::vector<Submap> submap_slots_;
  std::vector<std::unique_ptr<Scan>> scan_slots_;
  std::vector<Scan*> free_slots_;
  std::vector<std::unique_ptr<const GraphRevision>> revisions_;
  std::size_t num_under_way_ = 0;
  std::uint64_t num_commands_ = 0;
  Fill fill_;
  bool submap_finished_ = false;

  MissionRecord record_;
  std::vector<PlacedScan> placed_;

  FinishedTotals finished_;
  Doorbell reader_bell_, integration_bell_, scheduler_bell_, worker_bell_;
  SpscQueue<IntegrationCommand> commands_;
  SpscQueue<ScanReport> reports_;
  SpscQueue<SchedulerCommand> scheduler_commands_;
  SpscQueue<MapReturn> returns_;
  SpscQueue<const GraphRevision*> retired_;
  SpscQueue<OverlapBatch*> requests_;
  SpscQueue<OverlapBatch*> answers_;
  std::optional<OverlapWorker> worker_;
  std::optional<FusionScheduler> scheduler_;
  std::optional<IntegrationThread> integration_;
};

}  // namespace cloister
