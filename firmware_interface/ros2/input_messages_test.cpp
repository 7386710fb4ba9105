#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "firmware_interface/ros2/cdr_for_tests.hpp"
#include "firmware_interface/ros2/cdr_message.hpp"
#include "firmware_interface/ros2/message_parts.hpp"
#include "firmware_interface/ros2/odometry_message.hpp"
#include "firmware_interface/ros2/path_message.hpp"
#include "firmware_interface/ros2/static_transforms.hpp"

namespace cloister::ros2 {
namespace {

using cdr::Bytes;

Pose some_pose(double x) {
  return make_pose({x, -2 * x, 0.5}, Eigen::Quaterniond(Eigen::AngleAxisd(
                                         0.1 + x, Eigen::Vector3d(1, 2, 3).normalized())));
}

/// Messages of every kind that is read, as an independent encoder writes them.
std::vector<Bytes> samples_of(const dds_topic_descriptor_t& type, bool is_big) {
  const std::string name = type.m_typename;
  if (name.find("Odometry") != name.npos)
    return {cdr::write_odometry({1, 2, some_pose(1)}, is_big)};
  if (name.find("Path") != name.npos) {
    return {cdr::write_path(7, 8, {{1, 2, some_pose(1)}, {3, 4, some_pose(2)}}, is_big)};
  }
  if (name.find("TFMessage") != name.npos) {
    return {cdr::write_transforms({{"base", "mast", some_pose(1)}, {"mast", "os", some_pose(2)}},
                                  is_big)};
  }
  cdr::Cloud cloud;
  cloud.points.resize(2);
  return {cdr::write_cloud(cloud, is_big)};
}

TEST_CASE("an odometry message decodes to the same values in both byte orders") {
  for (const bool is_big : {false, true}) {
    CAPTURE(is_big);
    MessageCounters counters;
    Message<Odometry> message;
    REQUIRE(message.decode(cdr::write_odometry({1700000000, 999999999, some_pose(3)}, is_big),
                           counters));
    CHECK(message->pose.covariance[35] == 17.5);
    CHECK(message->twist.twist.angular.z == -5.0);
    CHECK(message->twist.covariance[1] == 0.25);
    OdometryDecoder decoder;
    const auto pose = decoder.pose(*message, counters);
    REQUIRE(pose);
    CHECK(pose->stamp.ns == 1'700'000'000'999'999'999);
    CHECK(pose->T_O_B.isApprox(some_pose(3), 1e-14));
    CHECK(decoder.odometry_frame() == "odom");
    CHECK(decoder.body_frame() == "body");
    CHECK(counters.drops().empty());
  }
}

TEST_CASE(
    "odometry that is no pose, has no proper stamp or speaks of other frames is counted and "
    "dropped") {
  OdometryDecoder decoder;
  MessageCounters counters;
  const auto decode = [&](const cdr::OdometrySample& sample) {
    Message<Odometry> message;
    REQUIRE(message.decode(cdr::write_odometry(sample, false), counters));
    return decoder.pose(*message, counters).has_value();
  };
  CHECK(decode({1, 0, some_pose(0), "/odom", "body"}));
  CHECK(decode({2, 0, some_pose(0), "odom", "/body"}));  // ROS 1's slash is no other frame
  CHECK_FALSE(decode({3, 1'000'000'000, some_pose(0)}));
  CHECK_FALSE(decode({4, 0, some_pose(0), "vision", "body"}));
  CHECK_FALSE(decode({5, 0, some_pose(0), "odom", "hand"}));
  CHECK_FALSE(decode({6, 0, some_pose(std::numeric_limits<double>::quiet_NaN())}));

  Message<Odometry> blank;  // a driver that never filled its quaternion in
  set_header(blank->header, SensorTime{7}, "odom");
  set_text(blank->child_frame_id, "body");
  CHECK_FALSE(decoder.pose(*blank, counters));
  CHECK(counters[MessageCause::kBadStamp] == 1);
  CHECK(counters[MessageCause::kChangedFrame] == 2);
  CHECK(counters[MessageCause::kBadPose] == 2);
}

TEST_CASE("a path's poses move between revisions, and their stamps say which node is which") {
  for (const bool is_big : {false, true}) {
    CAPTURE(is_big);
    PathDecoder decoder;
    MessageCounters counters;
    const auto graph_of = [&](const Bytes& bytes) {
      Message<Path> message;
      REQUIRE(message.decode(bytes, counters));
      return decoder.graph(*message, counters);
    };
    const auto first =
        graph_of(cdr::write_path(30, 5, {{10, 0, some_pose(1)}, {20, 0, some_pose(2)}}, is_big));
    REQUIRE(first);
    CHECK(first->stamp.ns == 30'000'000'005);
    REQUIRE(first->nodes.size() == 2);
    CHECK(first->edges.empty());
    CHECK(first->nodes[1].id == 1);
    CHECK(first->nodes[1].has_stamp);
    CHECK(first->nodes[1].stamp.ns == 20'000'000'000);
    CHECK(first->nodes[1].T_M_N.isApprox(some_pose(2), 1e-14));

    // Out of order, one node new, one moved, one gone for now; without a stamp of its own.
    const auto second =
        graph_of(cdr::write_path(0, 0, {{40, 0, some_pose(4)}, {20, 0, some_pose(5)}}, is_big));
    REQUIRE(second);
    CHECK(second->stamp.ns == 40'000'000'000);
    REQUIRE(second->nodes.size() == 2);
    CHECK(second->nodes[0].id == 1);
    CHECK(second->nodes[0].T_M_N.isApprox(some_pose(5), 1e-14));
    CHECK(second->nodes[1].id == 2);

    const auto third = graph_of(cdr::write_path(50, 0, {{10, 0, some_pose(6)}}, is_big));
    REQUIRE(third);
    CHECK(third->nodes[0].id == 0);
    CHECK(counters.drops().empty());
    CHECK(decoder.map_frame() == "map");
  }
}

TEST_CASE("a path whose nodes cannot be told apart is dropped, and changes nothing") {
  PathDecoder decoder;
  MessageCounters counters;
  const auto is_taken = [&](const Bytes& bytes) {
    Message<Path> message;
    REQUIRE(message.decode(bytes, counters));
    return decoder.graph(*message, counters).has_value();
  };
  CHECK_FALSE(is_taken(cdr::write_path(1, 0, {}, false)));
  CHECK_FALSE(is_taken(cdr::write_path(1, 0, {{0, 0}, {0, 0, some_pose(1)}}, false)));
  CHECK_FALSE(is_taken(cdr::write_path(1, 0, {{1, 2'000'000'000}}, false)));
  CHECK(is_taken(cdr::write_path(1, 0, {{5, 0}}, false)));
  CHECK_FALSE(is_taken(cdr::write_path(1, 0, {{6, 0}}, false, "plan")));
  CHECK(counters[MessageCause::kEmptyPath] == 1);
  CHECK(counters[MessageCause::kAmbiguousPath] == 1);
  CHECK(counters[MessageCause::kBadStamp] == 1);
  CHECK(counters[MessageCause::kChangedFrame] == 1);
}

TEST_CASE("static transforms join frames along any chain, up and down") {
  for (const bool is_big : {false, true}) {
    StaticTransforms transforms;
    MessageCounters counters;
    Message<TFMessage> message;
    REQUIRE(message.decode(cdr::write_transforms({{"body", "mast", some_pose(1)},
                                                  {"mast", "os_sensor", some_pose(2)},
                                                  {"/os_sensor", "/os_lidar", some_pose(3)},
                                                  {"body", "camera", some_pose(4)}},
                                                 is_big),
                           counters));
    transforms.add(*message, counters);
    CHECK(transforms.num_frames() == 4);
    const Pose chain = some_pose(1) * some_pose(2) * some_pose(3);
    REQUIRE(transforms.find("body", "os_lidar"));
    CHECK(transforms.find("body", "os_lidar")->isApprox(chain, 1e-12));
    REQUIRE(transforms.find("os_lidar", "body"));
    CHECK(transforms.find("os_lidar", "body")->isApprox(chain.inverse(), 1e-12));
    REQUIRE(transforms.find("camera", "os_lidar"));
    CHECK(transforms.find("camera", "os_lidar")->isApprox(some_pose(4).inverse() * chain, 1e-12));
    CHECK(transforms.find("body", "body")->isApprox(Pose::Identity()));
    CHECK_FALSE(transforms.find("body", "gripper"));
    CHECK(counters.drops().empty());
  }
}

TEST_CASE("a frame gets neither a second parent nor becomes its own ancestor") {
  StaticTransforms transforms;
  MessageCounters counters;
  Message<TFMessage> message;
  REQUIRE(message.decode(cdr::write_transforms({{"a", "b", some_pose(1)},
                                                {"b", "c", some_pose(1)},
                                                {"c", "a", some_pose(1)},
                                                {"d", "c", some_pose(1)},
                                                {"e", "e", some_pose(1)},
                                                {"a", "b", some_pose(2)}},
                                               false),
                         counters));
  transforms.add(*message, counters);
  CHECK(counters[MessageCause::kConflictingTransform] == 3);
  CHECK(transforms.find("a", "b")->isApprox(some_pose(2), 1e-12));  // moved, not doubled
}

TEST_CASE_TEMPLATE("a message cut off anywhere is refused, and the one before it stands", Topic,
                   Odometry, Path, TFMessage, PointCloud2) {
  for (const bool is_big : {false, true}) {
    for (const Bytes& whole : samples_of(descriptor<Topic>(), is_big)) {
      MessageCounters counters;
      Message<Topic> message;
      REQUIRE(message.decode(whole, counters));
      const std::vector<std::byte> before = message.encode();
      for (std::size_t size = 0; size < whole.size(); ++size) {
        CAPTURE(size);
        // A copy of its own, so that the address sanitizer sees a step too far.
        const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        REQUIRE_FALSE(message.decode(cut, counters));
      }
      CHECK(message.encode() == before);
      CHECK(counters[MessageCause::kUnknownEncapsulation] == 4);
      CHECK(counters[MessageCause::kMalformedMessage] == whole.size() - 4);

      Bytes padded = whole;
      padded.resize(padded.size() + 3);
      CHECK(message.decode(padded, counters));
    }
  }
}

TEST_CASE_TEMPLATE("a message with flipped bytes is refused or read, never believed beyond its end",
                   Topic, Odometry, Path, TFMessage, PointCloud2) {
  const unsigned seed = 11;
  CAPTURE(seed);
  std::mt19937 rng(seed);
  int num_refused = 0;
  for (const bool is_big : {false, true}) {
    const Bytes whole = samples_of(descriptor<Topic>(), is_big).front();
    Message<Topic> message;
    MessageCounters counters;
    for (int i = 0; i < 2000; ++i) {
      Bytes bytes = whole;
      for (unsigned flips = 1 + rng() % 4; flips > 0; --flips) {
        bytes[rng() % bytes.size()] = static_cast<std::byte>(rng());
      }
      num_refused += !message.decode(bytes, counters);
    }
  }
  CHECK(num_refused > 0);
}

TEST_CASE("only plain CDR is read") {
  Bytes bytes = cdr::write_odometry({1, 2, some_pose(1)}, false);
  for (const int kind : {2, 3, 6, 7, 8, 9, 10, 11, 255}) {
    CAPTURE(kind);
    MessageCounters counters;
    Message<Odometry> message;
    bytes[1] = static_cast<std::byte>(kind);
    CHECK_FALSE(message.decode(bytes, counters));
    CHECK(counters[MessageCause::kUnknownEncapsulation] == 1);
  }
  bytes[1] = std::byte{1};
  bytes[3] = std::byte{3};  // options that some middlewares set
  MessageCounters counters;
  Message<Odometry> message;
  CHECK(message.decode(bytes, counters));
}

TEST_CASE("stamps before 1970 and beyond 2038 do not wrap") {
  CHECK(stamp_of(time_of(SensorTime{-1}))->ns == -1);
  CHECK(stamp_of(time_of(SensorTime{-1'500'000'000}))->ns == -1'500'000'000);
  CHECK(time_of(SensorTime{4'000'000'000'000'000'000}).sec ==
        std::numeric_limits<std::int32_t>::max());
}

}  // namespace
}  // namespace cloister::ros2
