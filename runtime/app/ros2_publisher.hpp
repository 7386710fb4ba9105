#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <string>
#include <utility>

#include "firmware_interface/dds/native_topics.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "firmware_interface/ros2/map_topics.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// Shows the map to ROS 2's tools.
///
/// What is shown of submaps is read between two scans, when nothing is under way, and bounded: of the submaps that have
/// changed, those that were shown longest ago come first, and what is too much for one message comes a second later.
/// For an OctoMap, the submaps around the robot are copied then, and combined on a thread of its own.
///
/// Threads: the reader's, which the pipeline knows.
class Ros2Publisher {
 public:
  struct Options {
    std::string map_frame;
    std::string odometry_frame;
    bool transform = true;        ///< publish map -> odom
    double octomap_radius_m = 0;  ///< submaps that come nearer to the robot are local
  };

  Ros2Publisher(ros2::MapTopics& topics, Pipeline& pipeline, Options options)
      : topics_(topics), pipeline_(pipeline), options_(std::move(options)) {}

  void publish(const Diagnostics& diagnostics);
  /// While the pipeline is idle.
  void publish(const SubmapList& list, const PoseGraph& graph);
  /// Where odometry's frame lies, once for each scan that was integrated.
  void publish_transform(const LiveFeed& feed);
  /// Takes a copy for whoever asked for an OctoMap, if the pipeline is idle, and publishes what is ready.
  void serve_octomap();

  [[nodiscard]] std::int64_t num_refused() const { return topics_.num_refused(); }

 private:
  struct Shown {
    std::uint32_t version = 0;
    std::uint64_t turn = 0;  ///< when it was shown
  };

  void publish_markers(const SubmapList& list, const PoseGraph& graph);
  void publish_occupied(const SubmapList& list);
  [[nodiscard]] const Submap* find(SubmapId id) const;

  ros2::MapTopics& topics_;
  Pipeline& pipeline_;
  Options options_;
  SensorTime transform_stamp_;
  double num_drops_ = 0;
  std::uint64_t turn_ = 0;
  std::map<SubmapId, Shown> shown_;
  bool is_octomap_asked_ = false;
  SensorTime octomap_stamp_;
  std::future<Result<std::string>> octomap_;  ///< being written, or written
};

}  // namespace cloister
