#include "runtime/lent_threads.hpp"

#include <thread>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include "runtime/cpu_clock.hpp"

namespace cloister {

struct LentThreads::Arena : tbb::task_arena {
  using tbb::task_arena::task_arena;
};

LentThreads::LentThreads(int num) : num_(num), arena_(std::make_unique<Arena>(num)) {}

LentThreads::~LentThreads() = default;

void LentThreads::run(void (*task)(void* context, int worker), void* context) {
  // TBB orders what is before and after its tasks, but unseen: Debian's library is not instrumented. Said once more, so
  // that the thread sanitizer knows it: release here and in each task, acquire in each task and here.
  std::atomic<int> num_done{0};
  num_done.store(0, std::memory_order_release);
  const std::thread::id caller = std::this_thread::get_id();
  const auto run_one = [&](int worker) {
    (void)num_done.load(std::memory_order_acquire);
    const StopWatch watch;
    task(context, worker);
    if (std::this_thread::get_id() != caller)
      cpu_ns_.fetch_add(watch.cpu_ns(), std::memory_order_relaxed);
    num_done.fetch_add(1, std::memory_order_release);
  };
  arena_->execute([&] { tbb::parallel_for(0, num_, run_one, tbb::static_partitioner()); });
  (void)num_done.load(std::memory_order_acquire);
}

}  // namespace cloister
