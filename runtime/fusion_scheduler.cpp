#include "runtime/fusion_scheduler.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "runtime/thread_name.hpp"

namespace cloister {
namespace {

Event pair_event(EventKind kind, SensorTime stamp, const Submap& a, const Submap& b,
                 const VoxelOverlap& overlap) {
  return {.kind = kind,
          .stamp = stamp,
          .a = a.id,
          .b = b.id,
          .ratio_a = overlap.ratio_a(),
          .ratio_b = overlap.ratio_b(),
          .node_a = a.root,
          .node_b = b.root};
}

}  // namespace

FusionScheduler::FusionScheduler(ElasticMap& map, double fusion_reserve, std::size_t max_submaps,
                                 const SchedulerPorts& ports)
    : map_(map),
      ports_(ports),
      reserve_blocks_(static_cast<std::size_t>(
          fusion_reserve * static_cast<double>(map.pools().store.num_blocks()))),
      reserve_chunks_(static_cast<std::size_t>(
          fusion_reserve * static_cast<double>(map.pools().store.num_chunks()))),
      kept_places_(max_submaps),
      thread_([this] { run(); }) {}

FusionScheduler::~FusionScheduler() {
  if (thread_.joinable()) stop();
}

void FusionScheduler::stop() {
  // Release pairs with the acquire in run(): commands queued before stop() are seen, and done, before the end.
  stop_.store(true, std::memory_order_release);
  ports_.bell.ring();
  thread_.join();
}

void FusionScheduler::run() {
  name_this_thread("fusion");
  while (true) {
    const std::uint32_t seen = ports_.bell.count();
    const bool is_stopping = stop_.load(std::memory_order_acquire);
    SchedulerCommand command;
    if (ports_.commands.try_pop(command)) {
      handle(command);
      // Release pairs with num_done(): the reader may look at whatever this command changed.
      num_done_.fetch_add(1, std::memory_order_release);
      ports_.reader_bell.ring();
      continue;
    }
    if (is_stopping) return;
    ports_.bell.wait(seen);
  }
}

void FusionScheduler::handle(const SchedulerCommand& command) {
  if (command.finished != nullptr) map_.add(command.finished);
  if (command.revision != nullptr) {
    record_.lost_roots += map_.set_graph(command.revision);
    // The integration thread moved on before it sent this; now nobody uses the old revision.
    if (revision_ != nullptr) (void)ports_.retired.try_push(revision_);
    revision_ = command.revision;
    for (const std::size_t i : revision_->new_loops) {
      const GraphEdge& edge = revision_->graph.edges[i];
      record_.events.push_back({.kind = EventKind::kLoopClosure,
                                .stamp = command.stamp,
                                .a = map_.owner(edge.from),
                                .b = map_.owner(edge.to),
                                .node_a = edge.from,
                                .node_b = edge.to});
    }
    record_.events.push_back({.kind = EventKind::kGraphUpdated,
                              .stamp = command.stamp,
                              .count = static_cast<std::int64_t>(revision_->graph.nodes.size())});
  }
  fuse_all(command.stamp);
  share_places();
  absorb_remnants(command.stamp);
  send_surplus();
}

void FusionScheduler::fuse_all(SensorTime stamp) {
  while (true) {
    std::vector<PairCheck> checks = map_.plan_checks();
    if (!checks.empty()) compare(std::move(checks), stamp);
    const std::optional<FusionCandidate> candidate = map_.next_candidate();
    if (!candidate) break;
    decide(*candidate, stamp);
  }
}

void FusionScheduler::share_places() {
  const StopWatch watch;
  const std::int64_t bytes_before = map_.bytes();
  const std::size_t moved = map_.share_places();
  record_.cpu_fusion_ns += watch.cpu_ns();
  record_.blocks_shared += static_cast<std::int64_t>(moved);
  // A sum that only the reports read: relaxed order is enough.
  ports_.finished.bytes.fetch_add(map_.bytes() - bytes_before, std::memory_order_relaxed);
}

void FusionScheduler::absorb_remnants(SensorTime stamp) {
  while (true) {
    const StopWatch watch;
    const std::optional<FusionCandidate> remnant = map_.find_remnant();
    if (!remnant) break;
    ++(remnant->by_loop ? record_.proposed_by_loop : record_.proposed_by_overlap);
    Event event = pair_event(EventKind::kFusionAccepted, stamp, *map_.find(remnant->a), *map_.find(remnant->b),
                             remnant->overlap);
    event.reason = "remnant";
    if (const Judgement judgement = judge(*remnant); judgement.sigma_m) event.sigma_m = *judgement.sigma_m;
    if (!fuse(event, watch, [&] { return map_.absorb(*remnant); })) break;
  }
}

void FusionScheduler::compare(std::vector<PairCheck> checks, SensorTime stamp) {
  batch_.checks = std::move(checks);
  (void)ports_.requests.try_push(&batch_);  // cannot fail: there is one batch
  ports_.worker_bell.ring();
  for (OverlapBatch* answer = nullptr; answer == nullptr;) {
    const std::uint32_t seen = ports_.bell.count();
    if (!ports_.answers.try_pop(answer)) ports_.bell.wait(seen);
  }
  for (const PairCheck& check : batch_.checks) {
    map_.record(check);
    Event event = pair_event(EventKind::kOverlapChecked, stamp, *check.a, *check.b, check.overlap);
    if (const Judgement judgement = judge({check.a->id, check.b->id, false, check.overlap});
        judgement.sigma_m) {
      event.sigma_m = *judgement.sigma_m;
    }
    record_.events.push_back(event);
    if (map_.overlaps_enough(check)) continue;
    ++record_.rejected_by_overlap;
    event.kind = EventKind::kFusionRejected;
    event.reason = "overlap";
    record_.events.push_back(event);
  }
  record_.overlap_ms.insert(record_.overlap_ms.end(), batch_.milliseconds.begin(),
                            batch_.milliseconds.end());
}

Judgement FusionScheduler::judge(const FusionCandidate& candidate) {
  const StopWatch watch;
  const Judgement judgement = map_.judge(candidate);
  record_.uncertainty_ms.push_back(watch.wall_ms());
  record_.cpu_uncertainty_ns += watch.cpu_ns();
  return judgement;
}

void FusionScheduler::decide(const FusionCandidate& candidate, SensorTime stamp) {
  ++(candidate.by_loop ? record_.proposed_by_loop : record_.proposed_by_overlap);
  const Judgement judgement = judge(candidate);
  const Submap& a = *map_.find(candidate.a);
  const Submap& b = *map_.find(candidate.b);
  Event event = pair_event(EventKind::kFusionRejected, stamp, a, b, candidate.overlap);
  event.reason = judgement.is_uncertainty_unavailable ? "uncertainty_unavailable" : "uncertainty";
  if (judgement.sigma_m) event.sigma_m = *judgement.sigma_m;
  if (!judgement.is_accepted) {
    ++record_.rejected_by_uncertainty;
    record_.events.push_back(event);
    return;
  }
  const StopWatch fuse_watch;
  const std::optional<SurfaceAlignment> alignment = map_.agree(candidate, judgement);
  if (!alignment) {
    record_.cpu_fusion_ns += fuse_watch.cpu_ns();
    ++record_.rejected_by_overlap;
    event.reason = "surfaces";
    record_.events.push_back(event);
    return;
  }
  event.kind = EventKind::kFusionAccepted;
  event.shift_m = alignment->shift_m;
  event.reason = candidate.goes_on ? "continued" : candidate.by_loop ? "loop" : "overlap";
  (void)fuse(event, fuse_watch, [&] { return map_.fuse(candidate, alignment->T_b_a); });
}

template <typename Fusion>
bool FusionScheduler::fuse(Event& event, const StopWatch& watch, Fusion&& fusion) {
  const std::int64_t bytes_before = map_.bytes();
  Submap* emptied = nullptr;
  try {
    emptied = fusion();
  } catch (const std::bad_alloc&) {
    // What the one may have taken over already is still in the other: nothing is lost.
  }
  // Sums that only the reports read: relaxed order is enough.
  ports_.finished.bytes.fetch_add(map_.bytes() - bytes_before, std::memory_order_relaxed);
  record_.fuse_ms.push_back(watch.wall_ms());
  record_.cpu_fusion_ns += watch.cpu_ns();
  if (emptied == nullptr) {
    ++record_.declined_by_memory;
    event.kind = EventKind::kFusionRejected;
    event.reason = "memory";
    record_.events.push_back(event);
    return false;
  }
  ++record_.accepted;
  record_.events.push_back(event);
  ports_.finished.count.fetch_sub(1, std::memory_order_relaxed);
  MapReturn item;
  item.empty_slot = emptied;
  push(item);
  return true;
}

void FusionScheduler::push(const MapReturn& item) {
  // Cannot fail: send_surplus leaves a place for every submap, and each is on its way at most once.
  (void)ports_.returns.try_push(item);
  ports_.integration_bell.ring();
}

void FusionScheduler::send_surplus() {
  VoxelPools& pools = map_.pools();
  while (ports_.returns.depth() + kept_places_ < ports_.returns.capacity()) {
    MapReturn item;
    const auto surplus = [&](const PoolShare& share, std::size_t reserve, std::size_t room) {
      return static_cast<std::uint32_t>(
          std::min(share.num_free() > reserve ? share.num_free() - reserve : 0, room));
    };
    item.num_blocks = surplus(pools.blocks, reserve_blocks_, item.items.size());
    item.num_chunks = surplus(pools.chunks, reserve_chunks_, item.items.size() - item.num_blocks);
    if (item.num_blocks + item.num_chunks == 0) return;
    for (std::uint32_t i = 0; i < item.num_blocks; ++i) item.items[i] = pools.blocks.try_acquire();
    for (std::uint32_t i = 0; i < item.num_chunks; ++i)
      item.items[item.num_blocks + i] = pools.chunks.try_acquire();
    push(item);
  }
}

}  // namespace cloister
