#include "firmware_interface/ros2/topic_qos.hpp"

namespace cloister::ros2 {

QosPtr make_qos(const TopicQos& profile) {
  // What rmw's writers wait for a full reader before they give up.
  constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);
  QosPtr qos(dds_create_qos());
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, profile.depth);
  dds_qset_reliability(qos.get(),
                       profile.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kMaxBlocking);
  if (profile.is_latched) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, profile.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  }
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

std::string dds_topic_name(std::string_view ros_name) {
  if (ros_name.starts_with('/')) ros_name.remove_prefix(1);
  return "rt/" + std::string(ros_name);
}

}  // namespace cloister::ros2
