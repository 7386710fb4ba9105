#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "firmware_interface/dds/dds_link.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "firmware_interface/ros2/message_counters.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/scan/scan.hpp"

/// The topics of a robot's drivers and of its SLAM system, as ROS 2 has them in DDS ("rt/" before the name, types
/// `package::msg::dds_::Name_`), read and written without ROS. Nothing of it goes through shared memory.
namespace cloister::ros2 {

/// Names as ROS 2 has them.
struct DriverTopicNames {
  std::string points = "/ouster/points";  ///< sensor_msgs/PointCloud2
  std::string odometry = "/odometry";     ///< nav_msgs/Odometry; empty: there is none
  std::string path = "/path";  ///< nav_msgs/Path, the re-optimised trajectory; empty: there is none
  std::string static_transforms = "/tf_static";  ///< tf2_msgs/TFMessage
};

/// The mapper's ends: what drivers publish as what the mapper knows, by the decoders that also read recordings.
///
/// Threads: one at a time. Each `take` removes one item that can be used and returns false when there is none; what
/// cannot be used is counted. Nothing waits but `wait`.
class DriverListener {
 public:
  /// Scans have no more columns than that.
  static constexpr std::size_t kMaxColumns = 4096;

  struct Options {
    DriverTopicNames names;
    /// Asks for clouds and odometry to be sent again when they are lost: publishers that do not offer it are not heard.
    bool is_reliable = false;
    std::size_t max_points = 0;  ///< larger clouds are counted and dropped
  };

  [[nodiscard]] static Result<DriverListener> open(const DdsLink& link, const Options& options);
  DriverListener(DriverListener&&) noexcept;
  DriverListener& operator=(DriverListener&&) noexcept;
  ~DriverListener();

  /// Waits until something can be taken, or the time is over.
  void wait(std::chrono::milliseconds timeout);

  bool take(OdometrySample& sample);
  bool take(GraphUpdate& update);
  /// Fills all that PointCloudDecoder does.
  bool take(Scan& scan);
  /// When the scan taken last was written, Unix time. Nothing when that may have been on another host, by its clock.
  [[nodiscard]] std::optional<std::int64_t> scan_written_ns() const;

  /// The clouds' frame in that of odometry and path: by the static transforms that have come so far, between the frames
  /// that clouds and odometry name. Without odometry the path's poses are those of the clouds' frame.
  [[nodiscard]] std::optional<Pose> T_body_cloud();
  /// Name of O; empty before the first odometry.
  [[nodiscard]] const std::string& odometry_frame() const;
  /// One line for what is odd, but can be lived with; empty when nothing is.
  [[nodiscard]] std::string warning() const;

  [[nodiscard]] const MessageCounters& counters() const;

 private:
  struct Ends;
  explicit DriverListener(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

/// The robot's ends: publishes what ouster-ros, an odometry driver and a SLAM system would.
class DriverTopics {
 public:
  // Frames of what is published, O -> B -> L and M.
  static constexpr const char* kMapFrame = "map";
  static constexpr const char* kOdometryFrame = "odom";
  static constexpr const char* kBodyFrame = "body";
  static constexpr const char* kSensorFrame = "os_sensor";

  [[nodiscard]] static Result<DriverTopics> open(const DdsLink& link,
                                                 const DriverTopicNames& names);
  DriverTopics(DriverTopics&&) noexcept;
  DriverTopics& operator=(DriverTopics&&) noexcept;
  ~DriverTopics();

  /// Waits until somebody reads clouds, odometry, paths and static transforms.
  /// @return whether somebody does
  [[nodiscard]] bool wait_for_mapper(std::chrono::milliseconds timeout);

  // Each returns false when DDS did not take it: nobody reads as fast as it is written.
  [[nodiscard]] bool publish(const StampedPose& odometry);
  [[nodiscard]] bool publish(const PoseGraph& graph);
  [[nodiscard]] bool publish(const Scan& scan);
  /// Latched, as /tf_static is.
  [[nodiscard]] bool publish_sensor_pose(const Pose& T_body_sensor);

 private:
  struct Ends;
  explicit DriverTopics(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

}  // namespace cloister::ros2
