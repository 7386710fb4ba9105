#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/dds/dds_link.hpp"
#include "firmware_interface/mission/graph_keeper.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "firmware_interface/ouster/counters.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/scan/scan.hpp"
#include "mapping/submap/submap.hpp"

/// Cloister's own topics (cloister_native.idl), as plain types.
///
/// | topic                | from   | quality of service                       | transport                          |
/// |----------------------|--------|------------------------------------------|------------------------------------|
/// | cloister/scan        | robot  | reliable, last 32                        | shared memory where there is, UDP  |
/// | cloister/odometry    | robot  | reliable, last 256                       | UDP: 72 bytes                      |
/// | cloister/graph       | robot  | reliable, last 1024                      | UDP: must not be lost in bursts    |
/// | cloister/sensor      | robot  | reliable, latched                        | UDP: latched and of any size       |
/// | cloister/submaps     | mapper | reliable, latched                        | UDP                                |
/// | cloister/diagnostics | mapper | reliable, last 1                         | UDP                                |
/// | cloister/save_map    | client | reliable, last 8; save_map_reply back    | UDP                                |
namespace cloister {

/// The largest scan that the topic carries.
inline constexpr std::size_t kMaxTopicPixels = 65536;
inline constexpr std::size_t kMaxTopicColumns = 2048;

/// What a scan's pixels mean.
struct SensorDescription {
  std::string metadata_json;
  Pose T_pose_sensor = Pose::Identity();  ///< the sensor in the frame whose poses are published
};

/// A submap as the mapper tells others about it.
struct SubmapState {
  SubmapId id = kNoSubmap;
  std::uint32_t version = 0;  ///< grows whenever its voxels or its pose change
  bool is_active = false;
  NodeId root_node = kNoNode;
  Pose T_M_S = Pose::Identity();
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;
};

struct SubmapList {
  SensorTime stamp;  ///< of the newest scan in them
  std::uint64_t graph_revision = 0;
  std::vector<SubmapState> submaps;
};

struct Diagnostics {
  SensorTime stamp;
  std::vector<std::pair<std::string, double>> values;
};

struct SaveMapRequest {
  std::uint64_t id = 0;  ///< chosen by who asks, repeated in the reply
};

struct SaveMapReply {
  std::uint64_t id = 0;
  bool is_saved = false;
  std::string message;  ///< why not
  std::string path;     ///< absolute
  std::uint64_t bytes = 0;
};

/// What arrived over DDS.
enum class TopicCause {
  kScansInPlace,
  kScansCopied,
  kScanMalformed,
  kGraphPartMalformed,
  kGraphIncomplete,
  kScansLost,
  kCount,
};

constexpr std::array<CounterName, 6> counter_names(TopicCause) {
  return {{{"scans_read_in_shared_memory"},
           {"scans_read_over_udp"},
           {"scan_malformed", true},        // its size is none, or not that of the sensor
           {"graph_part_malformed", true},  // counts or numbers of parts that contradict each other
           {"graph_incomplete", true},      // a newer revision began before all parts had come
           {"scans_lost_on_the_way", true}}};  // gaps in the publisher's numbers
}

/// The mapper's ends of the topics.
///
/// Threads: one at a time. Each `take` removes one item that has arrived and returns false when there is none; nothing
/// waits but `wait`. Scans are read where they lie in shared memory and copied once, into the caller's scan.
class MapperTopics {
 public:
  [[nodiscard]] static Result<MapperTopics> open(const DdsLink& link);
  MapperTopics(MapperTopics&&) noexcept;
  MapperTopics& operator=(MapperTopics&&) noexcept;
  ~MapperTopics();

  /// Waits until something can be taken, or the time is over.
  void wait(std::chrono::milliseconds timeout);

  bool take(SensorDescription& sensor);
  bool take(OdometrySample& sample);
  bool take(GraphUpdate& update);
  /// Fills kind, stamps, ranges and columns; the caller sets the geometry.
  /// @param num_beams, num_columns  what the sensor has; other scans are counted and dropped
  bool take(Scan& scan, int num_beams, int num_columns);
  bool take(SaveMapRequest& request);
  /// When the scan taken last was written, Unix time. Nothing when that may have been on another host, by its clock.
  [[nodiscard]] std::optional<std::int64_t> scan_written_ns() const;

  void publish(const SubmapList& list);
  void publish(const Diagnostics& diagnostics);
  void publish(const SaveMapReply& reply);

  [[nodiscard]] const Counters<TopicCause>& counters() const;

 private:
  struct Ends;
  explicit MapperTopics(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

/// The robot's ends of the topics, and those of whoever watches the mapper.
class RobotTopics {
 public:
  [[nodiscard]] static Result<RobotTopics> open(const DdsLink& link);
  RobotTopics(RobotTopics&&) noexcept;
  RobotTopics& operator=(RobotTopics&&) noexcept;
  ~RobotTopics();

  /// Waits until somebody reads scans, odometry and graphs. What is sent right after a match can still be lost on its
  /// way through shared memory, so some time more is given then.
  /// @return whether somebody does
  bool wait_for_mapper(std::chrono::milliseconds timeout);

  // Each returns false when DDS did not take it: nobody reads as fast as it is written, or memory is out.
  bool publish(const SensorDescription& sensor);
  bool publish(const OdometrySample& sample);
  bool publish(const GraphUpdate& update);
  bool publish(const Scan& scan, int num_beams, int num_columns);
  bool publish(const SaveMapRequest& request);

  bool take(SubmapList& list);
  bool take(Diagnostics& diagnostics);
  bool take(SaveMapReply& reply);

 private:
  struct Ends;
  explicit RobotTopics(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

}  // namespace cloister
