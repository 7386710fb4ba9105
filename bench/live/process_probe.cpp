#include "bench/live/process_probe.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <system_error>

namespace cloister {
namespace {

double tick_s() { return 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK)); }

/// Calls `use` with the id, the name and the CPU seconds of each thread.
void for_each_thread(pid_t process,
                     const std::function<void(pid_t, const std::string&, double)>& use) {
  std::error_code error;
  const std::filesystem::path tasks = "/proc/" + std::to_string(process) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
    std::ifstream file(task.path() / "stat");
    std::string line;
    std::getline(file, line);
    // "id (name) state", 10 numbers, user ticks, system ticks; a name may hold anything.
    const std::size_t open = line.find('('), close = line.rfind(')');
    if (open == std::string::npos || close == std::string::npos) continue;
    std::istringstream rest(line.substr(close + 1));
    std::string skipped;
    for (int i = 0; i < 11; ++i) rest >> skipped;
    double user = 0, system = 0;
    rest >> user >> system;
    const pid_t id = std::stoi(task.path().filename());
    use(id, id == process ? "main" : line.substr(open + 1, close - open - 1),
        (user + system) * tick_s());
  }
}

}  // namespace

std::map<std::string, double> thread_cpu_s(pid_t process) {
  std::map<std::string, double> seconds;
  for_each_thread(process,
                  [&](pid_t, const std::string& name, double cpu_s) { seconds[name] += cpu_s; });
  return seconds;
}

pid_t find_thread(pid_t process, const std::string& wanted) {
  pid_t found = 0;
  for_each_thread(process, [&](pid_t id, const std::string& name, double) {
    if (name == wanted) found = id;
  });
  return found;
}

MachineTime machine_time() {
  std::ifstream file("/proc/stat");
  std::string word;
  file >> word;
  MachineTime time;
  // user, nice, system, idle, waiting for a disk, and times of interrupts and other machines.
  double ticks = 0;
  for (int i = 0; i < 8 && file >> ticks; ++i) {
    time.all_s += ticks * tick_s();
    if (i != 3 && i != 4) time.busy_s += ticks * tick_s();
  }
  return time;
}

}  // namespace cloister
