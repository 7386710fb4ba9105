#include "runtime/overlap_worker.hpp"

#include <atomic>

#include "runtime/cpu_clock.hpp"
#include "runtime/thread_name.hpp"

namespace cloister {

OverlapWorker::OverlapWorker(const VoxelStore& store, double voxel_size_m, int num_threads,
                             SpscQueue<OverlapBatch*>& requests, SpscQueue<OverlapBatch*>& answers, Doorbell& bell,
                             Doorbell& scheduler_bell)
    : store_(store),
      voxel_size_m_(voxel_size_m),
      workers_(num_threads),
      requests_(requests),
      answers_(answers),
      bell_(bell),
      scheduler_bell_(scheduler_bell),
      thread_([this] { run(); }) {}

OverlapWorker::~OverlapWorker() {
  // Release pairs with the acquire in run(); the scheduler has taken back all batches before this.
  stop_.store(true, std::memory_order_release);
  bell_.ring();
  thread_.join();
}

void OverlapWorker::run() {
  name_this_thread("overlap");
  while (true) {
    const std::uint32_t seen = bell_.count();
    OverlapBatch* batch = nullptr;
    if (requests_.try_pop(batch)) {
      compare(*batch);
      (void)answers_.try_push(batch);  // cannot fail: there is one batch
      scheduler_bell_.ring();
      continue;
    }
    if (stop_.load(std::memory_order_acquire)) return;
    bell_.wait(seen);
  }
}

void OverlapWorker::compare(OverlapBatch& batch) {
  batch.milliseconds.assign(batch.checks.size(), 0);
  const auto compare_one = [&](std::size_t i) {
    const StopWatch watch;
    PairCheck& check = batch.checks[i];
    check.overlap = voxel_overlap(store_, check.a->volume, check.b->volume, check.T_b_a, voxel_size_m_);
    batch.milliseconds[i] = watch.wall_ms();
    // A sum that is read for the summary only.
    cpu_ns_.fetch_add(watch.cpu_ns(), std::memory_order_relaxed);
  };
  // Each worker takes the next pair that nobody has: only the numbers are shared, so relaxed order is enough.
  std::atomic<std::size_t> next{0};
  auto compare_all = [&] {
    const auto take = [&] { return next.fetch_add(1, std::memory_order_relaxed); };
    for (std::size_t i = take(); i < batch.checks.size(); i = take()) compare_one(i);
  };
  workers_.run([](void* context, int) { (*static_cast<decltype(compare_all)*>(context))(); },
               &compare_all);
}

}  // namespace cloister
