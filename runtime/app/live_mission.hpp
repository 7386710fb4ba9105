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
#include "runtime/app/status_publisher.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// A mission while it happens: brings what arrives to the pipeline, and what becomes of it back to DDS. One thread.
class LiveMission {
 public:
  struct Parts {
    DdsLink* link = nullptr;
    MapperTopics* topics = nullptr;
    std::optional<UdpSource> socket;  ///< set: scans come straight from the sensor
    SensorMetadata metadata;
    Pose T_pose_sensor = Pose::Identity();
    std::filesystem::path out;
  };

  LiveMission(Parts parts, const ProgramConfig& config);

  /// Waits for something to arrive, at most a few milliseconds, and deals with it.
  void step();
  /// False when scans are under way and none has been integrated for ten seconds: the pipeline hangs.
  [[nodiscard]] bool is_moving() const { return Clock::now() - last_move_ < kPatience; }
  /// Integrates what still waits, and completes the record.
  void finish();

  [[nodiscard]] Pipeline& pipeline() { return *pipeline_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{10};

  void collect(Clock::time_point now);
  void wait();
  void take_in(Clock::time_point now);
  void take_packets(Clock::time_point now);
  void take_assembled(Clock::time_point now);
  void feed_pipeline(Clock::time_point now);
  void answer_requests();
  [[nodiscard]] std::map<std::string, std::int64_t> counts(bool only_drops) const;

  Parts parts_;
  ScanGeometry geometry_;
  std::optional<ScanAssembler> assembler_;
  LiveFeed feed_;
  std::optional<Pipeline> pipeline_;
  std::optional<StatusPublisher> status_;
  Scan next_;
  Clock::time_point last_move_ = Clock::now();
  std::uint64_t num_done_ = 0;
};

}  // namespace cloister
