#include "runtime/integration_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <utility>

#include "runtime/cpu_clock.hpp"
#include "runtime/thread_name.hpp"

namespace cloister {

IntegrationThread::IntegrationThread(LocalMapper& mapper, const IntegrationPorts& ports,
                                     std::function<void()> on_start)
    : mapper_(mapper), ports_(ports), thread_([this, hook = std::move(on_start)] {
        name_this_thread("integration");
        if (hook) hook();
        run();
      }) {}

IntegrationThread::~IntegrationThread() {
  if (thread_.joinable()) stop();
}

bool IntegrationThread::raise_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &parameters) == 0;
}

void IntegrationThread::stop() {
  // Release pairs with the acquire in run(): commands queued before stop() are seen, and done, before the end.
  stop_.store(true, std::memory_order_release);
  ports_.bell.ring();
  thread_.join();
}

void IntegrationThread::run() {
  while (true) {
    const std::uint32_t seen = ports_.bell.count();
    const bool is_stopping = stop_.load(std::memory_order_acquire);
    IntegrationCommand command;
    const bool has_command = ports_.commands.try_pop(command);
    // After the pop: what had come back when the command was queued is there before the command is done, always.
    take_returns();
    if (has_command) {
      if (command.revision != nullptr) handle(command.revision);
      if (command.job.scan != nullptr) handle(command.job);
      // Release pairs with num_done(): the reader may look at whatever this command changed.
      num_done_.fetch_add(1, std::memory_order_release);
      ports_.reader_bell.ring();
      continue;
    }
    if (is_stopping) break;
    ports_.bell.wait(seen);
  }
  hand_over(mapper_.close(), now_, nullptr);
}

void IntegrationThread::take_returns() {
  MapReturn item;
  while (ports_.returns.try_pop(item)) {
    for (std::uint32_t i = 0; i < item.num_blocks; ++i) mapper_.pools().blocks.release(item.items[i]);
    for (std::uint32_t i = 0; i < item.num_chunks; ++i) {
      mapper_.pools().chunks.release(item.items[item.num_blocks + i]);
    }
    if (item.empty_slot != nullptr) mapper_.give_slot(item.empty_slot);
  }
}

void IntegrationThread::hand_over(Submap* finished, SensorTime stamp, const GraphRevision* revision) {
  if (finished == nullptr && revision == nullptr) return;
  if (finished != nullptr) {
    // The totals are sums that only the reports read: relaxed order is enough.
    ports_.finished.bytes.fetch_add(static_cast<std::int64_t>(finished->volume.bytes()), std::memory_order_relaxed);
    ports_.finished.count.fetch_add(1, std::memory_order_relaxed);
  }
  // Cannot fail: the queue has a place for every submap and every revision in flight.
  (void)ports_.scheduler.try_push({stamp, finished, revision});
  num_handed_over_.fetch_add(1, std::memory_order_release);  // pairs with num_handed_over()
  ports_.scheduler_bell.ring();
}

void IntegrationThread::handle(const GraphRevision* revision) {
  now_ = std::max(now_, revision->graph.stamp);
  mapper_.set_graph(revision);
  hand_over(nullptr, revision->graph.stamp, revision);
}

void IntegrationThread::handle(const ScanJob& job) {
  ScanReport report;
  report.scan = job.scan;
  report.queue_depth = static_cast<std::int32_t>(ports_.commands.depth());
  now_ = std::max(now_, job.scan->stamp);

  const StopWatch place_watch;
  const bool is_placed = mapper_.place(*job.scan, report.outcome);
  report.integrate_ms = place_watch.wall_ms();
  report.integration_cpu_ns = place_watch.cpu_ns();

  const StopWatch spawn_watch;
  const bool is_accepted = is_placed && mapper_.check_spawn(*job.scan, report.outcome);
  report.spawn_check_cpu_ns = spawn_watch.cpu_ns();

  if (is_accepted) {
    const StopWatch integrate_watch;
    mapper_.integrate(*job.scan, report.outcome);
    report.integrate_ms += integrate_watch.wall_ms();
    report.integration_cpu_ns += integrate_watch.cpu_ns();
    if (ports_.workers != nullptr) report.integration_cpu_ns += ports_.workers->take_cpu_ns();
  }
  // Summed up before the scheduler gets the finished submap: what it does with it must not race with the report.
  report.num_submaps = ports_.finished.count.load(std::memory_order_relaxed);
  report.map_bytes = ports_.finished.bytes.load(std::memory_order_relaxed);
  for (const Submap* submap : {mapper_.active(), static_cast<const Submap*>(report.outcome.finished)}) {
    if (submap == nullptr) continue;
    ++report.num_submaps;
    report.map_bytes += static_cast<std::int64_t>(submap->volume.bytes());
  }
  report.blocks_used = mapper_.pools().blocks.num_used();
  report.chunks_used = mapper_.pools().chunks.num_used();
  hand_over(report.outcome.finished, job.scan->stamp, nullptr);
  report.latency_ms =
      std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - job.last_packet).count();
  // Cannot fail: the queue has a place for every scan slot.
  (void)ports_.reports.try_push(report);
}

}  // namespace cloister
