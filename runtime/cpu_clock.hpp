#pragma once

#include <chrono>
#include <cstdint>

namespace cloister {

/// CPU time that the calling thread has used so far, in nanoseconds. A system call without side effects.
[[nodiscard]] std::int64_t thread_cpu_ns();

/// CPU time that the whole process has used so far, in nanoseconds.
[[nodiscard]] std::int64_t process_cpu_ns();

/// Peak resident set of the process, in bytes.
[[nodiscard]] std::int64_t peak_rss_bytes();

/// Wall and thread CPU time since construction.
class StopWatch {
 public:
  StopWatch() : wall_start_(std::chrono::steady_clock::now()), cpu_start_ns_(thread_cpu_ns()) {}
  [[nodiscard]] float wall_ms() const {
    return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - wall_start_).count();
  }
  [[nodiscard]] std::int64_t cpu_ns() const { return thread_cpu_ns() - cpu_start_ns_; }

 private:
  std::chrono::steady_clock::time_point wall_start_;
  std::int64_t cpu_start_ns_;
};

}  // namespace cloister
