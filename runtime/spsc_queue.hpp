#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <boost/lockfree/spsc_queue.hpp>

namespace cloister {

/// A bounded queue between two threads, with counters. Policy when full: the newest item is declined and counted; the
/// caller decides what that means. boost's queue is wait-free, allocates once, and is clean under the thread
/// sanitizer.
///
/// Threads: one producer calls `try_push`, one consumer `try_pop`; counters may be read by anyone at any time.
template <typename T>
class SpscQueue {
 public:
  explicit SpscQueue(std::size_t capacity) : queue_(capacity), capacity_(capacity) {}

  [[nodiscard]] bool try_push(const T& item) {
    if (!queue_.push(item)) {
      // Counters are statistics: no other memory is published through them, so relaxed order is enough.
      num_declined_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    const std::size_t depth = queue_.read_available();
    if (depth > high_water_.load(std::memory_order_relaxed)) high_water_.store(depth, std::memory_order_relaxed);
    return true;
  }
  [[nodiscard]] bool try_pop(T& item) { return queue_.pop(item); }

  [[nodiscard]] std::size_t depth() const { return queue_.read_available(); }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] std::size_t high_water() const { return high_water_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t num_declined() const { return num_declined_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::size_t capacity_;
  std::atomic<std::size_t> high_water_{0};  ///< written by the producer only
  std::atomic<std::uint64_t> num_declined_{0};
};

}  // namespace cloister
