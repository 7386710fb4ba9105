#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <dds/dds.h>

namespace cloister::ros2 {

/// How ROS 2 offers and asks for a topic. History is always KEEP_LAST.
struct TopicQos {
  bool is_reliable = false;
  bool is_latched = false;  ///< transient-local: whoever comes late gets the last `depth` samples
  int depth = 1;
};

// ROS 2's own profiles. A writer that offers less than a reader asks for is not heard: best effort and volatile hears all.
inline constexpr TopicQos kSensorData{false, false, 5};
inline constexpr TopicQos kDefaultTopic{true, false, 10};
inline constexpr TopicQos kLatchedTopic{true, true, 1};

/// The profile of each topic that Cloister reads or writes. How much a reader keeps is its own affair: more than usual,
/// since the mapper stands still while it saves.
inline constexpr TopicQos kPointCloudInput{false, false, 16};
inline constexpr TopicQos kOdometryInput{false, false, 512};
inline constexpr TopicQos kPathInput = kDefaultTopic;
inline constexpr TopicQos kStaticTransformsInput{true, true, 100};
inline constexpr TopicQos kMarkersOutput = kLatchedTopic;
inline constexpr TopicQos kOccupiedCloudOutput = kLatchedTopic;
inline constexpr TopicQos kTransformsOutput{true, false, 100};
inline constexpr TopicQos kOctomapOutput = kLatchedTopic;
inline constexpr TopicQos kDiagnosticsOutput = kDefaultTopic;
inline constexpr TopicQos kRequestInput = kSensorData;

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, QosDeleter>;

/// The profile for a reader or writer of Cyclone DDS. Samples do not travel through shared memory: these types vary in
/// size, and iceoryx gives latched samples to no late reader. So reader and writer must not share a participant.
[[nodiscard]] QosPtr make_qos(const TopicQos& profile);

/// The name that a ROS 2 topic has in DDS: "/os/points" and "os/points" are "rt/os/points".
[[nodiscard]] std::string dds_topic_name(std::string_view ros_name);

}  // namespace cloister::ros2
