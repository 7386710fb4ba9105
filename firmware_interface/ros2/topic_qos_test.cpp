#include "firmware_interface/ros2/topic_qos.hpp"

#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/ros2/ros2_types.hpp"

namespace cloister::ros2 {
namespace {

template <typename Topic>
void check_type(const std::string& name) {
  const dds_topic_descriptor_t& type = descriptor<Topic>();
  CAPTURE(name);
  CHECK(type.m_typename == name);
  // ROS 2 sends no type information, nor restricts how data are represented.
  CHECK((type.m_flagset & DDS_TOPIC_XTYPES_METADATA) == 0);
  CHECK((type.m_flagset & DDS_TOPIC_RESTRICT_DATA_REPRESENTATION) == 0);
  CHECK(type.type_information.sz == 0);
  CHECK(type.type_mapping.sz == 0);
  CHECK(type.m_nkeys == 0);
}

TEST_CASE("types are called as ROS 2 calls them, and carry no type information") {
  check_type<PointCloud2>("sensor_msgs::msg::dds_::PointCloud2_");
  check_type<Odometry>("nav_msgs::msg::dds_::Odometry_");
  check_type<Path>("nav_msgs::msg::dds_::Path_");
  check_type<TFMessage>("tf2_msgs::msg::dds_::TFMessage_");
  check_type<MarkerArray>("visualization_msgs::msg::dds_::MarkerArray_");
  check_type<DiagnosticArray>("diagnostic_msgs::msg::dds_::DiagnosticArray_");
  check_type<Empty>("std_msgs::msg::dds_::Empty_");
  check_type<OctomapMessage>("octomap_msgs::msg::dds_::Octomap_");
}

TEST_CASE("the profiles are those of ROS 2") {
  const auto check = [](const TopicQos& profile, bool is_reliable, bool is_latched, int depth) {
    const QosPtr qos = make_qos(profile);
    dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
    REQUIRE(dds_qget_reliability(qos.get(), &reliability, nullptr));
    CHECK((reliability == DDS_RELIABILITY_RELIABLE) == is_reliable);
    dds_durability_kind_t durability = DDS_DURABILITY_PERSISTENT;
    REQUIRE(dds_qget_durability(qos.get(), &durability));
    CHECK(durability == (is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE));
    dds_history_kind_t history = DDS_HISTORY_KEEP_ALL;
    std::int32_t kept = 0;
    REQUIRE(dds_qget_history(qos.get(), &history, &kept));
    CHECK(history == DDS_HISTORY_KEEP_LAST);
    CHECK(kept == depth);
    if (!is_latched) return;
    REQUIRE(dds_qget_durability_service(qos.get(), nullptr, &history, &kept, nullptr, nullptr,
                                        nullptr));
    CHECK(history == DDS_HISTORY_KEEP_LAST);
    CHECK(kept == depth);
  };
  check(kSensorData, false, false, 5);
  check(kDefaultTopic, true, false, 10);
  check(kLatchedTopic, true, true, 1);
}

TEST_CASE("topics get the prefix of ROS 2") {
  CHECK(dds_topic_name("/ouster/points") == "rt/ouster/points");
  CHECK(dds_topic_name("tf") == "rt/tf");
}

}  // namespace
}  // namespace cloister::ros2
