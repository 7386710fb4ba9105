#include "bench/live/live_run.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>
#include <utility>

#include <sys/mman.h>

#include "bench/experiments/json_file.hpp"
#include "bench/live/process_probe.hpp"
#include "bench/support/allocation_counter.hpp"
#include "bench/support/private_host.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kStartTimeout{30};
constexpr std::chrono::seconds kRestTimeout{10};
// A mission is no longer than this.
constexpr std::chrono::hours kPlayTimeout{2};

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Looks again and again until it is so. @return seconds that took, nothing when it took too long
std::optional<double> wait_until(std::chrono::milliseconds timeout,
                                 const std::function<bool()>& is_so) {
  const auto begin = Clock::now();
  while (!is_so()) {
    if (Clock::now() - begin > timeout) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Programs that are started while this lives have a priority in real time.
class ChildPriority {
 public:
  explicit ChildPriority(int priority) : is_set_(priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = priority;
    if (is_set_) has_failed_ = sched_setscheduler(0, SCHED_RR, &parameters) != 0;
  }
  ~ChildPriority() {
    const sched_param parameters{};
    if (is_set_) (void)sched_setscheduler(0, SCHED_OTHER, &parameters);
  }
  ChildPriority(const ChildPriority&) = delete;
  ChildPriority& operator=(const ChildPriority&) = delete;
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  bool is_set_;
  bool has_failed_ = false;
};

/// The counts that a program keeps which has the allocation counter put before it.
class AllocationFile {
 public:
  explicit AllocationFile(const fs::path& path) : path_(path) {
    const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) return;
    if (ftruncate(fd, kBytes) == 0) {
      void* const at = mmap(nullptr, kBytes, PROT_READ, MAP_SHARED, fd, 0);
      if (at != MAP_FAILED) places_ = static_cast<const AllocationCounts*>(at);
    }
    close(fd);
  }
  ~AllocationFile() {
    if (places_ != nullptr) munmap(const_cast<AllocationCounts*>(places_), kBytes);
  }
  AllocationFile(const AllocationFile&) = delete;
  AllocationFile& operator=(const AllocationFile&) = delete;

  /// What `env` has to set for the program.
  [[nodiscard]] std::vector<std::string> environment(const fs::path& counter) const {
    return {"LD_PRELOAD=" + counter.string(),
            std::string(kAllocationFileVariable) + "=" + path_.string()};
  }
  /// Allocations of a thread so far. One that has never allocated or freed anything has no place.
  [[nodiscard]] std::optional<std::int64_t> of_thread(pid_t id) const {
    if (places_ == nullptr || id == 0) return std::nullopt;
    for (std::size_t i = 0; i < kMaxCountedThreads; ++i) {
      if (places_[i].thread_id == id) return places_[i].allocations;
    }
    // Of use only if the program has found the file at all.
    return places_[0].thread_id == 0 ? std::nullopt : std::optional<std::int64_t>(0);
  }

 private:
  static constexpr std::size_t kBytes = kMaxCountedThreads * sizeof(AllocationCounts);
  fs::path path_;
  const AllocationCounts* places_ = nullptr;
};

std::vector<std::string> mapper_words(LiveTransport transport, const LiveOptions& options,
                                      const AllocationFile& allocations) {
  std::vector<std::string> words = {"env"};
  const auto environment =
      allocations.environment(options.programs / "libcloister-allocation-counter.so");
  words.insert(words.end(), environment.begin(), environment.end());
  const std::string out = options.out.string();
  words.insert(words.end(),
               {(options.programs / "cloister").string(), "run", "--out", out, "--progress"});
  std::vector<std::string> settings = options.settings;
  if (transport == LiveTransport::kPackets) settings.emplace_back("sensor.source=udp");
  if (transport == LiveTransport::kRos2) settings.emplace_back("sensor.source=ros2");
  if (transport == LiveTransport::kSharedMemory) settings.emplace_back("dds.shared_memory=on");
  for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
  return words;
}

std::vector<std::string> player_words(LiveTransport transport, const LiveOptions& options) {
  std::vector<std::string> words = {(options.programs / "cloister").string(), "play",
                                    options.mission.string()};
  if (transport == LiveTransport::kPackets) words.emplace_back("--udp");
  if (transport == LiveTransport::kRos2) words.emplace_back("--ros2");
  return words;
}

/// The number behind the last `key` in a text; 0 when there is none.
std::int64_t number_behind(const std::string& text, const std::string& key) {
  std::int64_t number = 0;
  const std::size_t at = text.rfind(key);
  if (at != std::string::npos) {
    const char* const begin = text.data() + at + key.size();
    std::from_chars(begin, text.data() + text.size(), number);
  }
  return number;
}

/// The mapper's first line, once it is there as a whole.
std::string transport_line(const std::string& log) {
  const std::size_t begin = log.find("cloister: "), end = log.find('\n');
  return begin == std::string::npos || end == std::string::npos || end < begin
             ? std::string()
             : log.substr(begin + 10, end - begin - 10);
}

Result<void> read_outputs(const fs::path& out, LiveFigures& figures) {
  auto summary = JsonFile::open(out / "summary.json");
  if (!summary) return tl::unexpected(summary.error());
  figures.received = summary->number<std::int64_t>("/scans/read");
  figures.integrated = summary->number<std::int64_t>("/scans/integrated");
  figures.dropped = summary->number<std::int64_t>("/scans/dropped");
  figures.fusions = summary->number<std::int64_t>("/fusions/accepted");
  figures.rss_peak_bytes = summary->number<std::int64_t>("/memory/rss_peak_bytes");
  figures.map_bytes_peak = summary->number<std::int64_t>("/memory/map_bytes_peak");
  if (const auto whole = summary->is_whole(); !whole) return whole;
  figures.drops = summary->root()["drops"].get<std::map<std::string, std::int64_t>>();
  const auto& counters = summary->root()["counters"];
  figures.in_shared_memory = counters.value("scans_read_in_shared_memory", std::int64_t{0});

  std::ifstream timeline(out / "timeline.csv");
  std::vector<float> latency_ms;
  std::string line;
  for (std::getline(timeline, line); std::getline(timeline, line);) {
    // stamp_ns, submap, integrate_ms, latency_ms, ...
    std::size_t at = 0;
    for (int i = 0; i < 3; ++i) at = line.find(',', at) + 1;
    latency_ms.push_back(std::strtof(line.c_str() + at, nullptr));
  }
  figures.over_limit = std::count_if(latency_ms.begin(), latency_ms.end(),
                                     [](float ms) { return ms > kLatencyLimitMs; });
  figures.latency_ms = summarise(std::move(latency_ms));
  return {};
}

}  // namespace

const std::map<std::string, LiveTransport>& live_transports() {
  static const std::map<std::string, LiveTransport> names = {
      {"shared-memory", LiveTransport::kSharedMemory},
      {"udp", LiveTransport::kUdp},
      {"packets", LiveTransport::kPackets},
      {"ros2", LiveTransport::kRos2}};
  return names;
}

std::string name_of(LiveTransport transport) {
  for (const auto& [name, value] : live_transports()) {
    if (value == transport) return name;
  }
  return {};
}

Result<LiveFigures> run_live_mission(LiveTransport transport, const LiveOptions& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  const ChildPriority priority(options.priority);
  if (priority.has_failed()) {
    return fail(ErrorKind::kResource, "real-time priority " + std::to_string(options.priority) +
                                          " is not permitted here: leave --priority out");
  }
  std::optional<Background> roudi;
  const fs::path roudi_log = options.out / "roudi.log";
  if (transport == LiveTransport::kSharedMemory) {
    roudi.emplace(
        std::vector<std::string>{"iox-roudi", "-m", "off", "-c", options.roudi_config.string()},
        roudi_log);
    const auto is_ready = [&] {
      return read_text(roudi_log).find("ready for clients") != std::string::npos;
    };
    if (!wait_until(kStartTimeout, is_ready))
      return fail(ErrorKind::kResource, "iox-roudi does not start: see " + roudi_log.string());
  }

  LiveFigures figures;
  const AllocationFile allocations(options.out / "allocations.bin");
  const fs::path run_log = options.out / "run.log", play_log = options.out / "play.log";
  Background mapper(mapper_words(transport, options, allocations), run_log);
  const auto known =
      wait_until(kStartTimeout, [&] { return !transport_line(read_text(run_log)).empty(); });
  if (!known)
    return fail(ErrorKind::kResource, "the mapper does not start: see " + run_log.string());
  figures.transport_known_s = *known;
  figures.transport_line = transport_line(read_text(run_log));

  const std::uint64_t bytes_before = loopback_bytes();
  const MachineTime before = machine_time();
  Background player(player_words(transport, options), play_log);
  if (player.wait(kPlayTimeout) != 0)
    return fail(ErrorKind::kResource, "the player fails: see " + play_log.string());
  // Lost scans never come: then this waits in vain, and they are in the table.
  (void)wait_until(kRestTimeout,
                   [&] { return number_behind(read_text(run_log), "scan ") >= options.num_scans; });
  const MachineTime after = machine_time();
  figures.machine_busy = (after.busy_s - before.busy_s) / (after.all_s - before.all_s);
  figures.loopback_bytes_per_scan =
      static_cast<double>(loopback_bytes() - bytes_before) / static_cast<double>(options.num_scans);
  figures.cpu_s = thread_cpu_s(mapper.id());
  figures.integration_allocations = allocations.of_thread(find_thread(mapper.id(), "integration"));
  if (const int status = mapper.end(SIGTERM); status != 0) {
    return fail(ErrorKind::kResource,
                "the mapper ends with " + std::to_string(status) + ": see " + run_log.string());
  }
  figures.refused = number_behind(read_text(play_log), "warning: ");
  if (const auto read = read_outputs(options.out, figures); !read)
    return tl::unexpected(read.error());
  return figures;
}

}  // namespace cloister
