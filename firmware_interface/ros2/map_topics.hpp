#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "firmware_interface/dds/dds_link.hpp"
#include "firmware_interface/map/map_contents.hpp"
#include "firmware_interface/ros2/map_parts.hpp"
#include "mapping/core/result.hpp"

namespace cloister::ros2 {

/// What the mapper publishes for ROS 2's tools.
///
/// | topic                     | type                               | quality of service     |
/// |---------------------------|------------------------------------|------------------------|
/// | /cloister/submaps         | visualization_msgs/MarkerArray     | reliable, latched      |
/// | /cloister/occupied        | sensor_msgs/PointCloud2            | reliable, latched      |
/// | /cloister/octomap         | octomap_msgs/Octomap               | reliable, latched      |
/// | /tf                       | tf2_msgs/TFMessage                 | reliable, last 100     |
/// | /diagnostics              | diagnostic_msgs/DiagnosticArray    | reliable, last 10      |
/// | /cloister/request_octomap | std_msgs/Empty, read by the mapper | best effort, last 5    |
///
/// Threads: one at a time. Nothing waits: what a slow reader leaves no room for is counted and dropped.
class MapTopics {
 public:
  [[nodiscard]] static Result<MapTopics> open(const DdsLink& link);
  MapTopics(MapTopics&&) noexcept;
  MapTopics& operator=(MapTopics&&) noexcept;
  ~MapTopics();

  void publish_submaps(const MessageHeader& header, std::span<const SubmapMarker> submaps,
                       std::span<const LoopMarker> loops);
  void publish_occupied(const MessageHeader& header, const MapView& map);
  /// @param data  of octomap_data: occupied or free
  void publish_octomap(const MessageHeader& header, double voxel_size_m, std::string_view data);
  void publish_transform(const MessageHeader& header, std::string_view child_frame_id,
                         const Pose& T_parent_child);
  void publish(SensorTime stamp, const Diagnostic& diagnostic);

  /// Readers of the occupied voxels.
  struct Readers {
    bool is_any = false;
    bool is_new = false;  ///< one has come since the last call: it knows nothing yet
  };
  [[nodiscard]] Readers readers_of_occupied();
  /// True once for any number of requests that have come.
  [[nodiscard]] bool take_octomap_request();

  /// Messages that a slow reader left no room for.
  [[nodiscard]] std::int64_t num_refused() const;

 private:
  struct Ends;
  explicit MapTopics(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

}  // namespace cloister::ros2
