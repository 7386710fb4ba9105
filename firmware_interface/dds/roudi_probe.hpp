#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace cloister {

/// What was found out about iceoryx' daemon, RouDi.
struct RouDiState {
  bool is_usable = false;
  std::string reason;  ///< why not, in a few words
  std::string
      locator;  ///< the same in all processes that see this instance of the daemon, and in no others
};

/// Finds out whether shared memory can be used, before the first DDS call: with shared memory switched on and no living
/// daemon, Cyclone would wait for a minute and then abort.
///
/// RouDi holds an exclusive lock on a file for as long as it lives, and the kernel drops it even when it is killed. That
/// it also answers, and has memory for samples of the given size, is tried in a child process, which may hang or abort
/// in our stead.
///
/// Threads: call it while the process has only one, since it forks. Takes some 10 ms, at most the time-out.
[[nodiscard]] RouDiState probe_roudi(std::size_t sample_bytes, std::chrono::milliseconds timeout);

}  // namespace cloister
