#pragma once

#include <chrono>
#include <cstdint>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// One line on stderr that is written over twice a second: scans, rate, submaps, memory.
class Progress {
 public:
  explicit Progress(bool is_shown) : is_shown_(is_shown) {}
  ~Progress();

  /// @param num_expected  how many scans the mission will have, roughly; 0 when not known
  void show(const MissionRecord& record, std::int64_t num_expected);

 private:
  using Clock = std::chrono::steady_clock;
  bool is_shown_;
  bool has_line_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

}  // namespace cloister
