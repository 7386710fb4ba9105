#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "runtime/app/ros2_publisher.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// Tells DDS once a second how the mapper is, and which submaps there are. The submaps are looked at between two scans,
/// when nothing is under way: while the mapper is busier than that, the list waits.
///
/// Threads: the reader's, which the pipeline knows.
class StatusPublisher {
 public:
  /// @param ros2  told the same; may be null
  StatusPublisher(MapperTopics& topics, Ros2Publisher* ros2, Pipeline& pipeline,
                  bool uses_shared_memory)
      : topics_(topics),
        ros2_(ros2),
        pipeline_(pipeline),
        uses_shared_memory_(uses_shared_memory) {}

  void publish_if_due(std::chrono::steady_clock::time_point now, const LiveFeed& feed,
                      const std::map<std::string, std::int64_t>& drops);

 private:
  using HostTime = std::chrono::steady_clock::time_point;

  void publish_diagnostics(HostTime now, const LiveFeed& feed,
                           const std::map<std::string, std::int64_t>& drops);
  void publish_submaps(const LiveFeed& feed);

  struct Known {
    std::uint32_t version = 0;
    std::uint64_t blocks = 0;
    std::uint64_t bytes = 0;
    std::size_t num_merged = 0;
    std::int64_t num_scans = -1;
    Pose T_M_S = Pose::Identity();
  };

  MapperTopics& topics_;
  Ros2Publisher* ros2_;
  Pipeline& pipeline_;
  bool uses_shared_memory_;
  HostTime last_diagnostics_;
  HostTime last_submaps_;
  std::int64_t last_integrated_ = 0;
  std::uint64_t last_odometry_ = 0;
  std::map<SubmapId, Known> known_;
};

}  // namespace cloister
