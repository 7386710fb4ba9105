#pragma once

namespace cloister {

/// Notes SIGINT and SIGTERM for as long as it lives, in place of ending the process. One at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// The signal that came, or 0.
  [[nodiscard]] static int number();
};

}  // namespace cloister
