#include "runtime/app/replay_command.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "firmware_interface/map/map_hash.hpp"
#include "firmware_interface/mission/mission_reader.hpp"
#include "runtime/app/outputs.hpp"
#include "runtime/app/progress.hpp"
#include "runtime/cpu_clock.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {
namespace {

volatile std::sig_atomic_t g_is_interrupted = 0;

void on_signal(int) { g_is_interrupted = 1; }

/// Holds scans back until their time has come, in the mission's own pace.
class Pacer {
 public:
  void wait_for(SensorTime stamp) {
    const auto now = std::chrono::steady_clock::now();
    if (!begin_) begin_ = {now, stamp};
    const auto due = begin_->first + std::chrono::nanoseconds((stamp - begin_->second).ns);
    // In slices, so that a signal is noticed within a mission's pauses.
    while (g_is_interrupted == 0 && std::chrono::steady_clock::now() < due) {
      std::this_thread::sleep_until(std::min(due, std::chrono::steady_clock::now() + std::chrono::milliseconds(100)));
    }
  }

 private:
  std::optional<std::pair<std::chrono::steady_clock::time_point, SensorTime>> begin_;
};

/// Feeds the mission to the pipeline until its end, a signal, or an input that cannot be read.
Result<void> feed(MissionReader& reader, Pipeline& pipeline, const ReplayOptions& options) {
  Progress progress(options.show_progress);
  Pacer pacer;
  // Scans are read into a slot of our own: in real time none of the pipeline's may be free.
  Scan next;
  next.reserve(reader.max_pixels(), reader.max_columns(), MissionReader::kMaxPoses);
  while (g_is_interrupted == 0) {
    const StopWatch decode_watch;
    auto item = reader.next(next);
    pipeline.record().cpu_decode_s += 1e-9 * static_cast<double>(decode_watch.cpu_ns());
    if (!item) return tl::unexpected(item.error());
    if (*item == MissionReader::Item::kEnd) return {};
    if (options.realtime) {
      if (*item == MissionReader::Item::kScan) pacer.wait_for(next.last_packet);
      pipeline.collect();
    } else {
      // Lockstep: nothing is under way while the map may change by anything but the next scan.
      pipeline.wait_for_scans(0);
      if (pipeline.take_submap_finished()) pipeline.drain();
    }
    if (*item == MissionReader::Item::kGraph) {
      pipeline.submit(reader.take_graph());
      if (!options.realtime) pipeline.drain();
    } else if (Scan* slot = pipeline.try_take_slot()) {
      std::swap(*slot, next);
      pipeline.submit(slot);
    } else {
      pipeline.drop(next, "scan_late");
    }
    progress.show(pipeline.record(), reader.num_scans_expected());
  }
  return {};
}

}  // namespace

Result<void> run_replay(const ReplayOptions& options, const ProgramConfig& config) {
  auto reader = MissionReader::open(options.mission, config.map);
  if (!reader) return tl::unexpected(reader.error());

  g_is_interrupted = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  Pipeline::Options capacity;
  capacity.max_scan_pixels = (*reader)->max_pixels();
  capacity.max_scan_columns = (*reader)->max_columns();
  capacity.max_scan_poses = MissionReader::kMaxPoses;
  ProgramConfig sized = config;
  sized.map.scan.max_points = static_cast<int>(capacity.max_scan_pixels);
  Pipeline pipeline(sized, capacity);
  const Result<void> fed = feed(**reader, pipeline, options);
  pipeline.finish();
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);

  MissionRecord& record = pipeline.record();
  record.config = config.map;
  record.mission = (*reader)->name();
  record.scans_read = (*reader)->num_scans_read();
  record.counters["returns_read"] = (*reader)->num_returns_read();
  record.scans_dropped += (*reader)->num_scans_unplaced();
  for (const auto& [cause, count] : (*reader)->drops()) record.drops[cause] += count;
  const std::vector<std::string> warnings = (*reader)->warnings();
  record.warnings.insert(record.warnings.end(), warnings.begin(), warnings.end());
  record.interrupted = g_is_interrupted != 0;
  record.map_hash = map_hash(pipeline.store(), pipeline.submaps());
  for (const std::string& warning : record.warnings) std::fprintf(stderr, "cloister: warning: %s\n", warning.c_str());

  // A mission that could not be read from its first scan on leaves nothing behind.
  if (!fed && record.scans_integrated == 0) return fed;
  if (auto written = write_outputs(pipeline, options.out); !written) return written;
  if (!fed) return fed;
  if (record.interrupted) {
    return fail(ErrorKind::kInterrupted, "interrupted after scan " + std::to_string(record.scans_integrated) +
                                             "; the outputs in " + options.out.string() + " are complete up to there");
  }
  return {};
}

}  // namespace cloister
