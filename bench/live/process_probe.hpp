#pragma once

#include <map>
#include <string>

#include <sys/types.h>

namespace cloister {

/// CPU seconds of each thread of a process that is still there, by the thread's name; those of one name together. The
/// thread that began the process is "main".
[[nodiscard]] std::map<std::string, double> thread_cpu_s(pid_t process);

/// Id of the process' thread of that name; 0 when there is none.
[[nodiscard]] pid_t find_thread(pid_t process, const std::string& name);

/// What the whole machine has been doing since it started, in CPU seconds of all cores.
struct MachineTime {
  double busy_s = 0;
  double all_s = 0;
};
[[nodiscard]] MachineTime machine_time();

}  // namespace cloister
