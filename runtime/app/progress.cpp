#include "runtime/app/progress.hpp"

#include <cstdio>

namespace cloister {

Progress::~Progress() {
  if (has_line_) std::fputc('\n', stderr);
}

void Progress::show(const MissionRecord& record, std::int64_t num_expected) {
  const Clock::time_point now = Clock::now();
  if (!is_shown_ || now - last_ < std::chrono::milliseconds(500)) return;
  last_ = now;
  has_line_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const auto integrated = static_cast<double>(record.scans_integrated);
  const TimelineRow newest = record.timeline.empty() ? TimelineRow{} : record.timeline.back();
  std::fprintf(stderr, "\rscan %lld of %s%lld  %.1f/s  %d submaps  %.1f MB   ",
               static_cast<long long>(record.scans_integrated), num_expected > 0 ? "about " : "?",
               static_cast<long long>(num_expected), integrated / seconds, newest.submaps,
               static_cast<double>(newest.map_bytes) * 1e-6);
  std::fflush(stderr);
}

}  // namespace cloister
