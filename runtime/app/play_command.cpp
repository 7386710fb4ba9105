#include "runtime/app/play_command.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <thread>
#include <utility>

#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/mission/mission_player.hpp"
#include "firmware_interface/ouster/udp_source.hpp"
#include "firmware_interface/ros2/driver_topics.hpp"
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

/// Who publishes: the robot with Cloister's topics, one of them in the shape of packets, or with those of ROS 2.
class Publisher {
 public:
  [[nodiscard]] static Result<Publisher> open(const DdsLink& link, const PlayOptions& options,
                                              const ros2::DriverTopicNames& names) {
    Publisher publisher;
    if (options.as_ros2) {
      auto opened = ros2::DriverTopics::open(link, names);
      if (!opened) return tl::unexpected(opened.error());
      publisher.drivers_.emplace(std::move(*opened));
      return publisher;
    }
    auto opened = RobotTopics::open(link);
    if (!opened) return tl::unexpected(opened.error());
    publisher.robot_.emplace(std::move(*opened));
    if (options.raw_packets) {
      auto sender = UdpSender::open(options.host, static_cast<std::uint16_t>(options.port));
      if (!sender) return tl::unexpected(sender.error());
      publisher.sender_.emplace(std::move(*sender));
    }
    return publisher;
  }

  /// What a mapper must know before the first scan.
  [[nodiscard]] bool describe_sensor(const MissionPlayer& mission) {
    if (drivers_) return drivers_->publish_sensor_pose(mission.T_pose_sensor());
    return robot_->publish(SensorDescription{mission.metadata_json(), mission.T_pose_sensor()});
  }
  [[nodiscard]] bool wait_for_mapper(std::chrono::milliseconds timeout) {
    return drivers_ ? drivers_->wait_for_mapper(timeout) : robot_->wait_for_mapper(timeout);
  }
  [[nodiscard]] bool publish(const MissionPlayer& mission, MissionPlayer::Item item) {
    switch (item) {
      case MissionPlayer::Item::kOdometry:
        if (drivers_) return drivers_->publish(mission.odometry());
        return robot_->publish(OdometrySample{mission.session(), mission.odometry()});
      case MissionPlayer::Item::kGraph:
        return drivers_ ? drivers_->publish(mission.graph().graph)
                        : robot_->publish(mission.graph());
      case MissionPlayer::Item::kScan:
        if (drivers_) return drivers_->publish(mission.scan());
        return robot_->publish(mission.scan(), mission.metadata().num_beams,
                               mission.metadata().num_columns);
      case MissionPlayer::Item::kPacket:
        return sender_->send(mission.packet());
      case MissionPlayer::Item::kEnd:
        break;
    }
    return true;
  }

 private:
  std::optional<RobotTopics> robot_;
  std::optional<UdpSender> sender_;
  std::optional<ros2::DriverTopics> drivers_;
};

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
  if (!options.raw_packets && !options.as_ros2 && pixels > kMaxTopicPixels) {
    return fail(ErrorKind::kInput, options.mission.string() + ": scans of " +
                                       std::to_string(num_beams) + " x " +
                                       std::to_string(num_columns) +
                                       " pixels do not fit into the topic; play it with --udp");
  }

  const StopSignal stop;
  auto link = DdsLink::open(settings->dds);
  if (!link) return tl::unexpected(link.error());
  auto publisher = Publisher::open(*link, options, settings->ros2_topics);
  if (!publisher) return tl::unexpected(publisher.error());
  std::int64_t refused = 0;
  const auto count = [&](bool is_sent) { refused += is_sent ? 0 : 1; };
  count(publisher->describe_sensor(mission));
  for (int i = 0; i < kWaitSlices && StopSignal::number() == 0; ++i) {
    if (publisher->wait_for_mapper(kWaitSlice)) break;
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
    // Too much odometry at once for the topic to keep: of the past, the last seconds are enough.
    if (*item == MissionPlayer::Item::kOdometry && ahead.ns < -Duration::from_seconds(2).ns)
      continue;
    count(publisher->publish(mission, *item));
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
