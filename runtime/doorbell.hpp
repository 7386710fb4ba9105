#pragma once

#include <atomic>
#include <cstdint>

namespace cloister {

/// Lets an idle thread sleep until somebody has put work into one of its queues. Ringing never blocks.
///
/// The consumer reads `count()`, looks into its queues, and sleeps only if the count is still the same: a ring between
/// the look and the sleep changes the count, so it cannot be missed.
class Doorbell {
 public:
  void ring() {
    // Release pairs with the acquire in count() and wait(): who has seen the ring sees what was queued before it.
    count_.fetch_add(1, std::memory_order_release);
    count_.notify_all();
  }
  [[nodiscard]] std::uint32_t count() const { return count_.load(std::memory_order_acquire); }
  void wait(std::uint32_t seen) const { count_.wait(seen, std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> count_{0};
};

}  // namespace cloister
