#include "runtime/pipeline.hpp"

#include <algorithm>
#include <string>

#include "mapping/core/vectors.hpp"
#include "mapping/scan/scan_motion.hpp"
#include "runtime/cpu_clock.hpp"

namespace cloister {
namespace {

// Share of the budget for voxel blocks; the rest is for chunks, which index them and hold coarse free space.
constexpr double kBlockShare = 0.75;
// Places of the returns queue for blocks and chunks, beside one for each submap.
constexpr std::size_t kReturnPlaces = 8192;

std::int64_t pool_bytes(const MemoryConfig& memory) {
  return memory.budget_bytes - static_cast<std::int64_t>(memory.max_submaps) * static_cast<std::int64_t>(sizeof(Submap));
}

std::size_t num_blocks(const MemoryConfig& memory) {
  return static_cast<std::size_t>(kBlockShare * static_cast<double>(pool_bytes(memory))) / sizeof(Block);
}

std::size_t num_chunks(const MemoryConfig& memory) {
  return static_cast<std::size_t>((1 - kBlockShare) * static_cast<double>(pool_bytes(memory))) / sizeof(Chunk);
}

/// Moves a share of one owner's free items to another, before the threads start.
void move_share(PoolShare& from, PoolShare& to, double share) {
  for (auto left = static_cast<std::size_t>(share * static_cast<double>(from.num_free())); left > 0; --left) {
    to.release(from.try_acquire());
  }
}

const char* name_of(SpawnReason reason) {
  switch (reason) {
    case SpawnReason::kFirst: return "first";
    case SpawnReason::kOverlap: return "overlap";
    case SpawnReason::kCorrection: return "correction";
    case SpawnReason::kDistance: return "distance";
    case SpawnReason::kNone: break;
  }
  return "none";
}

const char* name_of(ScanRefusal refusal) {
  switch (refusal) {
    case ScanRefusal::kNoPose: return "scan_without_pose";
    case ScanRefusal::kUnknownNode: return "scan_of_unknown_node";
    case ScanRefusal::kNoSubmapSlot: return "submap_slots_full";
    case ScanRefusal::kNone: break;
  }
  return "none";
}

}  // namespace

Pipeline::Pipeline(const ProgramConfig& config, const Options& options)
    : config_(config),
      store_(num_blocks(config.map.memory), num_chunks(config.map.memory)),
      warmer_(store_),
      workers_(config.runtime.integration_workers),
      mapper_(config.map, store_, &workers_),
      map_(config.map, store_),
      submap_slots_(static_cast<std::size_t>(config.map.memory.max_submaps)),
      commands_(static_cast<std::size_t>(config.runtime.scan_queue + config.runtime.graph_queue + 1)),
      reports_(static_cast<std::size_t>(config.runtime.scan_queue)),
      scheduler_commands_(submap_slots_.size() + static_cast<std::size_t>(config.runtime.graph_queue) + 1),
      returns_(submap_slots_.size() + kReturnPlaces),
      retired_(static_cast<std::size_t>(config.runtime.graph_queue) + 1),
      requests_(1),
      answers_(1) {
  limit_vector_bits(config.runtime.vector_bits);
  mapper_.pools().take_all();
  move_share(mapper_.pools().blocks, map_.pools().blocks, config.runtime.fusion_reserve);
  move_share(mapper_.pools().chunks, map_.pools().chunks, config.runtime.fusion_reserve);
  // The integration thread's items begin where those moved to the other share end.
  warmer_.keep_ahead(map_.pools().blocks.num_free(), map_.pools().chunks.num_free());
  for (std::size_t i = submap_slots_.size(); i-- > 0;) mapper_.give_slot(&submap_slots_[i]);
  for (int i = 0; i < config.runtime.scan_queue; ++i) {
    scan_slots_.push_back(std::make_unique<Scan>());
    scan_slots_.back()->reserve(options.max_scan_pixels, options.max_scan_columns, options.max_scan_poses);
    free_slots_.push_back(scan_slots_.back().get());
  }
  fill_.num_blocks = mapper_.pools().blocks.num_free();
  fill_.num_chunks = mapper_.pools().chunks.num_free();
  record_.config = config.map;
  record_.budget_bytes = config.map.memory.budget_bytes;
  record_.cloud_bytes = static_cast<std::int64_t>(mapper_.cloud().bytes());

  worker_.emplace(store_, config.map.voxel.voxel_size_m, config.runtime.overlap_workers, requests_, answers_,
                  worker_bell_, scheduler_bell_);
  scheduler_.emplace(map_, config.runtime.fusion_reserve, submap_slots_.size(),
                     SchedulerPorts{scheduler_commands_, returns_, retired_, requests_, answers_, scheduler_bell_,
                                    worker_bell_, integration_bell_, reader_bell_, finished_});
  integration_.emplace(mapper_,
                       IntegrationPorts{commands_, returns_, reports_, scheduler_commands_, integration_bell_,
                                        scheduler_bell_, reader_bell_, finished_, &workers_},
                       options.on_integration_start);
  const int priority = config.runtime.integration_priority;
  if (priority > 0 && !integration_->raise_priority(priority)) {
    record_.warnings.push_back("runtime.integration_priority = " + std::to_string(priority) +
                               " is not permitted here (CAP_SYS_NICE or a limit RTPRIO permits it): scans are "
                               "integrated at the priority of everything else");
  }
}

Pipeline::~Pipeline() {
  // The order of the data's path: nobody queues anything for a thread that has ended.
  integration_.reset();
  scheduler_.reset();
  worker_.reset();
}

Scan* Pipeline::try_take_slot() {
  if (free_slots_.empty()) return nullptr;
  Scan* slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

void Pipeline::submit(Scan* scan, std::chrono::steady_clock::time_point last_packet) {
  // Cannot fail: the queue has a place for every slot and every revision.
  (void)commands_.try_push({{scan, last_packet}, nullptr});
  ++num_under_way_;
  ++num_commands_;
  integration_bell_.ring();
}

void Pipeline::submit(std::unique_ptr<GraphRevision> revision) {
  reclaim_revisions();
  while (revisions_.size() >= static_cast<std::size_t>(config_.runtime.graph_queue)) {
    const std::uint32_t seen = reader_bell_.count();
    reclaim_revisions();
    if (revisions_.size() < static_cast<std::size_t>(config_.runtime.graph_queue)) break;
    reader_bell_.wait(seen);
  }
  (void)commands_.try_push({{}, revision.get()});
  revisions_.push_back(std::move(revision));
  ++num_commands_;
  integration_bell_.ring();
}

void Pipeline::reclaim_revisions() {
  for (const GraphRevision* retired = nullptr; retired_.try_pop(retired);) {
    std::erase_if(revisions_, [&](const auto& revision) { return revision.get() == retired; });
  }
}

std::size_t Pipeline::collect() {
  for (ScanReport report; reports_.try_pop(report);) {
    note(report);
    free_slots_.push_back(report.scan);
    --num_under_way_;
  }
  return num_under_way_;
}

void Pipeline::wait_for_scans(std::size_t max_under_way) {
  while (true) {
    const std::uint32_t seen = reader_bell_.count();
    if (collect() <= max_under_way) return;
    reader_bell_.wait(seen);
  }
}

void Pipeline::drain() {
  const auto wait_until = [&](auto&& is_done) {
    for (std::uint32_t seen = reader_bell_.count(); !is_done(); seen = reader_bell_.count()) {
      collect();
      if (is_done()) break;
      reader_bell_.wait(seen);
    }
  };
  wait_until([&] { return integration_->num_done() == num_commands_; });
  wait_until([&] { return scheduler_->num_done() == integration_->num_handed_over(); });
  // An empty command lets the integration thread take what the scheduler has sent back.
  (void)commands_.try_push({});
  ++num_commands_;
  integration_bell_.ring();
  wait_until([&] { return integration_->num_done() == num_commands_; });
  collect();
}

bool Pipeline::is_idle() const {
  return num_under_way_ == 0 && integration_->num_done() == num_commands_ &&
         scheduler_->num_done() == integration_->num_handed_over();
}

std::vector<const Submap*> Pipeline::present_submaps() const {
  std::vector<const Submap*> present = map_.submaps();
  if (mapper_.active() != nullptr) present.push_back(mapper_.active());
  return present;
}

Pipeline::Fill Pipeline::fill() const {
  Fill fill = fill_;
  fill.commands_waiting = commands_.depth();
  return fill;
}

void Pipeline::drop(const Scan& scan, const char* cause) {
  ++record_.scans_dropped;
  ++record_.drops[cause];
  record_.events.push_back({.kind = EventKind::kDrop, .stamp = scan.stamp, .reason = cause});
}

void Pipeline::note(const ScanReport& report) {
  warmer_.keep_ahead(report.blocks_used, report.chunks_used);
  fill_.blocks_used = report.blocks_used;
  fill_.chunks_used = report.chunks_used;
  const ScanOutcome& outcome = report.outcome;
  submap_finished_ |= outcome.finished != nullptr;
  record_.cpu_spawn_check_s += 1e-9 * static_cast<double>(report.spawn_check_cpu_ns);
  record_.cpu_integration_s += 1e-9 * static_cast<double>(report.integration_cpu_ns);
  if (outcome.submap == kNoSubmap) {
    drop(*report.scan, name_of(outcome.refusal));
    return;
  }
  ++record_.scans_integrated;
  record_.returns_integrated += static_cast<std::int64_t>(outcome.num_returns);
  if (outcome.returns_declined > 0) {
    record_.drops["returns_beyond_capacity"] += static_cast<std::int64_t>(outcome.returns_declined);
  }
  const auto degrade = [&](const char* drop, const char* reason, std::size_t count) {
    if (count == 0) return;
    record_.drops[drop] += static_cast<std::int64_t>(count);
    record_.events.push_back({.kind = EventKind::kDegrade,
                              .stamp = report.scan->stamp,
                              .reason = reason,
                              .a = outcome.submap,
                              .count = static_cast<std::int64_t>(count)});
  };
  degrade("voxel_updates_memory_full", "memory", outcome.voxels_declined);
  degrade("spawns_submap_slots_full", "submap_slots", outcome.is_spawn_declined);
  if (outcome.spawned != SpawnReason::kNone) {
    record_.events.push_back({.kind = EventKind::kSpawn,
                              .stamp = report.scan->stamp,
                              .reason = name_of(outcome.spawned),
                              .a = outcome.submap,
                              .ratio_a = outcome.overlap_ratio,
                              .node_a = outcome.node});
    ++record_.submaps_spawned;
  }
  TimelineRow row;
  row.stamp = report.scan->stamp;
  row.submap = outcome.submap;
  row.integrate_ms = report.integrate_ms;
  row.integration_cpu_ms = 1e-6f * static_cast<float>(report.integration_cpu_ns);
  row.latency_ms = report.latency_ms;
  row.submaps = report.num_submaps;
  row.map_bytes = report.map_bytes;
  row.queue_depth = report.queue_depth;
  row.overlap_ratio = static_cast<float>(outcome.overlap_ratio);
  row.T_M_L = outcome.T_M_L;
  record_.timeline.push_back(row);
  record_.submaps_peak = std::max<std::int64_t>(record_.submaps_peak, row.submaps);
  record_.map_bytes_peak = std::max(record_.map_bytes_peak, row.map_bytes);

  placed_.push_back(
      {row.stamp, outcome.node, outcome.submap, ScanMotion(report.scan->poses).T_R_L(row.stamp)});
}

void Pipeline::finish() {
  drain();
  integration_->stop();
  scheduler_->stop();
  collect();
  complete_record();
}

Pose Pipeline::final_pose(const PlacedScan& placed) const {
  const GraphRevision* revision = revisions_.empty() ? nullptr : revisions_.back().get();
  if (revision == nullptr) return placed.T_R_L;
  if (placed.node != kNoNode) {
    const GraphNode* node = revision->node(placed.node);
    return node != nullptr ? node->T_M_N * placed.T_R_L : placed.T_R_L;
  }
  // Taken before the first graph: by the first node whose odometry is known.
  for (std::size_t i = 0; i < revision->graph.nodes.size(); ++i) {
    if (revision->T_O_N[i]) return revision->graph.nodes[i].T_M_N * revision->T_O_N[i]->inverse() * placed.T_R_L;
  }
  return placed.T_R_L;
}

void Pipeline::complete_record() {
  const SchedulerRecord& scheduler = scheduler_->record();
  record_.events.insert(record_.events.end(), scheduler.events.begin(), scheduler.events.end());
  std::stable_sort(record_.events.begin(), record_.events.end(),
                   [](const Event& a, const Event& b) { return a.stamp < b.stamp; });
  record_.overlap_ms = scheduler.overlap_ms;
  record_.fuse_ms = scheduler.fuse_ms;
  record_.uncertainty_ms = scheduler.uncertainty_ms;
  record_.fusions_proposed_by_loop = scheduler.proposed_by_loop;
  record_.fusions_proposed_by_overlap = scheduler.proposed_by_overlap;
  record_.fusions_accepted = scheduler.accepted;
  record_.fusions_rejected_by_uncertainty = scheduler.rejected_by_uncertainty;
  record_.fusions_rejected_by_overlap = scheduler.rejected_by_overlap;
  record_.submaps_fused = scheduler.accepted;
  if (scheduler.declined_by_memory > 0) record_.drops["fusions_memory_full"] = scheduler.declined_by_memory;
  if (scheduler.lost_roots > 0) record_.drops["submap_roots_missing_from_graph"] = scheduler.lost_roots;
  record_.cpu_overlap_s = 1e-9 * static_cast<double>(worker_->cpu_ns());
  record_.cpu_fusion_s = 1e-9 * static_cast<double>(scheduler.cpu_fusion_ns);
  record_.cpu_uncertainty_s = 1e-9 * static_cast<double>(scheduler.cpu_uncertainty_ns);
  record_.counters["blocks_moved_to_nearer_submap"] = scheduler.blocks_shared;
  record_.counters["queue_scans_high_water"] = static_cast<std::int64_t>(commands_.high_water());
  record_.counters["queue_scheduler_high_water"] = static_cast<std::int64_t>(scheduler_commands_.high_water());
  record_.counters["queue_returns_high_water"] = static_cast<std::int64_t>(returns_.high_water());

  std::map<SubmapId, SubmapRecord> records;
  const double voxel_m = config_.map.voxel.voxel_size_m;
  for (const Submap* submap : map_.submaps()) {
    SubmapRecord& record = records[submap->id];
    record.id = submap->id;
    record.merged_from = submap->merged_from;
    record.root = submap->root;
    record.T_M_S = submap->T_M_S;
    record.blocks = static_cast<std::int64_t>(submap->volume.num_blocks());
    record.bytes = static_cast<std::int64_t>(submap->volume.bytes());
    record.observed_m3 =
        static_cast<double>(count_known(store_, submap->volume)) * voxel_m * voxel_m * voxel_m;
    const Eigen::AlignedBox3d bounds =
        known_bounds(store_, submap->volume, voxel_m).transformed(submap->T_M_S);
    if (!bounds.isEmpty()) {
      record.aabb_min_M = bounds.min();
      record.aabb_max_M = bounds.max();
    }
    submap->volume.for_each_block(store_, [&](const BlockCoord& coord, const BlockView& view) {
      if (view.block == nullptr) return;
      for (int i = 0; i < kBlockVoxels; ++i) {
        if (view.block->voxels[i] <= 0) continue;
        const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(i & 7, (i >> 3) & 7, i >> 6);
        record.surface_M.push_back(
            (submap->T_M_S * ((voxel.cast<double>().array() + 0.5).matrix() * voxel_m)).cast<float>());
      }
    });
    record_.observed_m3 += record.observed_m3;
    record_.map_bytes_final += record.bytes;
  }
  for (const PlacedScan& placed : placed_) {
    const Pose T_M_L = final_pose(placed);
    if (!record_.path_M.empty()) {
      record_.travel_m += (T_M_L.translation() - record_.path_M.back().second.translation()).norm();
    }
    record_.path_M.emplace_back(placed.stamp, T_M_L);
    const auto owner = records.find(map_.survivor(placed.submap));
    if (owner == records.end()) continue;
    owner->second.scan_stamps.push_back(placed.stamp);
    if (placed.node != kNoNode) owner->second.nodes.push_back(placed.node);
  }
  for (auto& [id, record] : records) {
    std::sort(record.nodes.begin(), record.nodes.end());
    record.nodes.erase(std::unique(record.nodes.begin(), record.nodes.end()), record.nodes.end());
    record_.submaps.push_back(std::move(record));
  }
  record_.submaps_final = static_cast<std::int64_t>(record_.submaps.size());
  record_.map_bytes_peak = std::max(record_.map_bytes_peak, record_.map_bytes_final);
  if (!placed_.empty()) record_.duration_s = (placed_.back().stamp - placed_.front().stamp).seconds();
  record_.rss_peak_bytes = peak_rss_bytes();
  record_.cpu_total_s = 1e-9 * static_cast<double>(process_cpu_ns());
}

}  // namespace cloister
