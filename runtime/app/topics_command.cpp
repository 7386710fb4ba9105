#include "runtime/app/topics_command.hpp"

#include <chrono>
#include <cstdio>

#include "firmware_interface/dds/topic_meter.hpp"
#include "runtime/app/live_settings.hpp"
#include "runtime/app/stop_signal.hpp"

namespace cloister {

Result<void> run_topics(double seconds, const ProgramConfig& config) {
  const auto settings = live_settings(config);
  if (!settings) return tl::unexpected(settings.error());
  const StopSignal stop;
  auto link = DdsLink::open(settings->dds);
  if (!link) return tl::unexpected(link.error());
  auto meter = TopicMeter::open(*link);
  if (!meter) return tl::unexpected(meter.error());
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  while (StopSignal::number() == 0 && elapsed_s() < seconds)
    meter->poll(std::chrono::milliseconds(20));

  const double watched_s = elapsed_s();
  std::printf("%-28s %-42s %8s %10s %12s\n", "topic", "type", "per s", "bytes", "bytes per s");
  for (const TopicMeter::Row& row : meter->rows()) {
    if (row.is_measured) {
      std::printf(
          "%-28s %-42s %8.1f %10.0f %12.0f\n", row.topic.c_str(), row.type.c_str(),
          static_cast<double>(row.count) / watched_s,
          row.count > 0 ? static_cast<double>(row.bytes) / static_cast<double>(row.count) : 0.0,
          static_cast<double>(row.bytes) / watched_s);
    } else {
      std::printf("%-28s %-42s %8s %10s %12s\n", row.topic.c_str(), row.type.c_str(), "-", "-",
                  "-");
    }
  }
  return {};
}

}  // namespace cloister
