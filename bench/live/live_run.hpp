#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mapping/core/result.hpp"
#include "mapping/record/mission_record.hpp"

namespace cloister {

/// How scans come from the player to the mapper.
enum class LiveTransport { kSharedMemory, kUdp, kPackets, kRos2 };

[[nodiscard]] const std::map<std::string, LiveTransport>& live_transports();
[[nodiscard]] std::string name_of(LiveTransport transport);

struct LiveOptions {
  std::filesystem::path mission;
  std::filesystem::path out;  ///< what the mapper leaves, and every program's log
  std::filesystem::path programs;
  std::filesystem::path roudi_config;
  std::int64_t num_scans = 0;         ///< in the mission
  std::vector<std::string> settings;  ///< of the mapper, key=value
  int priority = 0;                   ///< real-time priority of all programs; 0: as everything else
};

/// What a live mission cost, and what became of it.
struct LiveFigures {
  std::string transport_line;    ///< what the mapper said about it
  double transport_known_s = 0;  ///< after its start
  std::int64_t refused = 0;      ///< messages that the network did not take from the player
  std::int64_t received = 0, integrated = 0, dropped = 0;
  std::map<std::string, std::int64_t> drops;
  std::int64_t in_shared_memory = 0;  ///< scans read where the player wrote them
  std::int64_t fusions = 0;
  TimingSummary latency_ms;
  std::int64_t over_limit = 0;  ///< scans later than `kLatencyLimitMs`
  double loopback_bytes_per_scan = 0;
  std::optional<std::int64_t> integration_allocations;  ///< nothing: the thread was not found
  std::map<std::string, double> cpu_s;                  ///< of the mapper, by thread
  double machine_busy = 0;  ///< share of all cores that anybody used meanwhile
  std::int64_t rss_peak_bytes = 0, map_bytes_peak = 0;
};

inline constexpr double kLatencyLimitMs = 60;

/// Starts the mapper, plays the mission to it at its own pace, and ends it once it has integrated what came. For shared
/// memory RouDi is started before, and ended behind it. To be called in a private host.
/// Errors: kResource when a program cannot be started, fails or hangs; kInput when its outputs cannot be read
[[nodiscard]] Result<LiveFigures> run_live_mission(LiveTransport transport,
                                                   const LiveOptions& options);

}  // namespace cloister
