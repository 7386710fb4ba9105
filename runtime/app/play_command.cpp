#include "runtime/app/play_command.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <thread>

#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/mission/mission_player.hpp"
#include "firmware_interface/ouster/udp_source.hpp"
#include "runtime/app/live_settings.hpp"
#include "runtime/app/stop_signal.hpp"

namespace cloister {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWaitSlices = 100;
constexpr std::chrono::milliseconds kWaitSlice{100};
// What was sent last is still on its way when this process ends.
constexpr std::chrono::milliseconds kFarewell{500};

/// Waits, unless a signal comes.
void sleep_until(Clock::time_point due) {
  while (StopSignal::number() == 0 && Clock::now() < due) {
    std::this_thread::sleep_until(std::min(due, Clock::now() + kWaitSlice));
  }
}

}  // namespace

Result<void> run_play(const PlayOptions& options, const ProgramConfig& config) {
  const auto settings = live_settings(config);
  if (!settings) return tl::unexpected(settings.error());
  const auto lidar =
      options.raw_packets ? MissionPlayer::Lidar::kPackets : MissionPlayer::Lidar::kScans;
  auto player = MissionPlayer::open(options.mission, lidar);
  if (!player) return tl::unexpected(player.error());
  MissionPlayer& mission = **player;
  const int num_beams = mission.metadata().num_beams;
  const int num_columns = mission.metadata().num_columns;
  const auto pixels = static_cast<std::size_t>(num_beams) * static_cast<std::size_t>(num_columns);
  if (!options.raw_packets && pixels > kMaxTopicPixels) {
    return fail(ErrorKind::kInput, options.mission.string() + ": scans of " +
                                       std::to_string(num_beams) + " x " +
                                       std::to_string(num_columns) +
                                       " pixels do not fit into the topic; play it with --udp");
  }

  const StopSignal stop;
  auto link = DdsLink::open(settings->dds);
  if (!link) return tl::unexpected(link.error());
  auto topics = RobotTopics::open(*link);
  if (!topics) return tl::unexpected(topics.error());
  std::optional<UdpSender> sender;
  if (options.raw_packets) {
    auto opened = UdpSender::open(options.host, static_cast<std::uint16_t>(options.port));
    if (!opened) return tl::unexpected(opened.error());
    sender.emplace(std::move(*opened));
  }
  std::int64_t refused = 0;
  const auto count = [&](bool is_sent) { refused += is_sent ? 0 : 1; };
  count(topics->publish(SensorDescription{mission.metadata_json(), mission.T_pose_sensor()}));
  for (int i = 0; i < kWaitSlices && StopSignal::number() == 0; ++i) {
    if (topics->wait_for_mapper(kWaitSlice)) break;
  }

  std::optional<SensorTime> first;
  std::optional<Clock::time_point> begin;
  const Duration start = Duration::from_seconds(options.start_s);
  while (StopSignal::number() == 0) {
    const auto item = mission.next();
    if (!item) return tl::unexpected(item.error());
    if (*item == MissionPlayer::Item::kEnd) break;
    if (!first) first = mission.due();
    const Duration ahead = mission.due() - (*first + start);
    if (ahead.ns >= 0) {
      if (!begin) begin = Clock::now();
      sleep_until(*begin + std::chrono::nanoseconds(static_cast<std::int64_t>(
                               static_cast<double>(ahead.ns) / options.rate)));
    } else if (*item != MissionPlayer::Item::kOdometry && *item != MissionPlayer::Item::kGraph) {
      // Odometry and graphs of before are part of what is known at the start; scans are not.
      continue;
    }
    switch (*item) {
      case MissionPlayer::Item::kOdometry:
        // Too much at once for the topic to keep: of the past, the last seconds are enough.
        if (ahead.ns >= -Duration::from_seconds(2).ns)
          count(topics->publish(OdometrySample{mission.session(), mission.odometry()}));
        break;
      case MissionPlayer::Item::kGraph:
        count(topics->publish(mission.graph()));
        break;
      case MissionPlayer::Item::kScan:
        count(topics->publish(mission.scan(), num_beams, num_columns));
        break;
      case MissionPlayer::Item::kPacket:
        count(sender->send(mission.packet()));
        break;
      case MissionPlayer::Item::kEnd:
        break;
    }
  }
  if (refused > 0) {
    std::fprintf(stderr, "cloister: warning: %lld messages were not taken by the network\n",
                 static_cast<long long>(refused));
  }
  if (StopSignal::number() != 0)
    return fail(ErrorKind::kInterrupted, "interrupted; the mission was not played to its end");
  sleep_until(Clock::now() + kFarewell);
  return {};
}

}  // namespace cloister
