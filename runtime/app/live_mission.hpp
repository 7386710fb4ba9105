#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "firmware_interface/dds/dds_link.hpp"
#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "firmware_interface/ouster/scan_assembler.hpp"
#include "firmware_interface/ouster/udp_source.hpp"
#include "firmware_interface/ros2/driver_topics.hpp"
#include "firmware_interface/ros2/map_topics.hpp"
#include "runtime/app/map_service.hpp"
#include "runtime/app/ros2_publisher.hpp"
#include "runtime/app/status_publisher.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// A mission while it happens: brings what arrives to the pipeline, and what becomes of it back to DDS. One thread.
class LiveMission {
 public:
  struct Parts {
    DdsLink* link = nullptr;
    MapperTopics* topics = nullptr;
    MapRequests* requests = nullptr;
    std::optional<UdpSource> socket;  ///< set: scans come straight from the sensor
    /// Set: scans, odometry and graphs come as ROS 2's messages.
    std::optional<ros2::DriverListener> drivers;
    SensorMetadata metadata;  ///< not with `drivers`, which tell what a sensor is by its clouds
    std::optional<Pose> T_pose_sensor;  ///< needed but with `drivers`: as the static transforms say
    bool expects_odometry = true;
    ros2::MapTopics* ros2_map = nullptr;  ///< set: the map is shown to ROS 2's tools
    std::filesystem::path out;
  };

  LiveMission(Parts parts, const ProgramConfig& config);

  /// Waits for something to arrive, at most a few milliseconds, and deals with it.
  void step();
  /// False when scans are under way and none has been integrated for ten seconds: the pipeline hangs.
  [[nodiscard]] bool is_moving() const { return Clock::now() - last_move_ < kPatience; }
  /// Integrates what still waits, and completes the record.
  void finish();

  /// One line for what is odd about the input, but can be lived with; empty when nothing is.
  [[nodiscard]] std::string input_warning() const {
    return parts_.drivers ? parts_.drivers->warning() : std::string();
  }
  [[nodiscard]] Pipeline& pipeline() { return *pipeline_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{10};
  static constexpr Clock::time_point kEnd = Clock::time_point::max();

  /// Starts a pipeline with an empty map.
  void begin();
  void collect(Clock::time_point now);
  void wait();
  void take_in(Clock::time_point now);
  void take_from_drivers(Clock::time_point now);
  void take_packets();
  void take_assembled(Clock::time_point arrived);
  void feed_pipeline(Clock::time_point now);
  void answer_requests();
  [[nodiscard]] std::map<std::string, std::int64_t> counts(bool only_drops) const;

  Parts parts_;
  ProgramConfig config_;
  ScanGeometry geometry_;
  std::optional<ScanAssembler> assembler_;
  std::optional<LiveFeed> feed_;
  std::int64_t num_resets_ = 0;
  std::optional<Pipeline> pipeline_;
  std::optional<Ros2Publisher> ros2_;
  std::optional<StatusPublisher> status_;
  std::optional<MapService> service_;
  Scan next_;
  Clock::time_point last_move_ = Clock::now();
  std::uint64_t num_done_ = 0;
};

}  // namespace cloister
