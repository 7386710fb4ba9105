#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "mapping/core/pose.hpp"

/// CDR as its specification has it (XCDR version 1: a value of n bytes stands at a multiple of n, counted from behind
/// the encapsulation header), written for tests without any of the code they test.
namespace cloister::cdr {

using Bytes = std::vector<std::byte>;

class Writer {
 public:
  explicit Writer(bool is_big) : is_big_(is_big) {
    bytes_ = {std::byte{0}, std::byte(is_big ? 0 : 1), std::byte{0}, std::byte{0}};
  }

  template <typename Number>
  Writer& put(Number number) {
    while ((bytes_.size() - 4) % sizeof(Number) != 0) bytes_.push_back(std::byte{0});
    std::byte raw[sizeof(Number)];
    std::memcpy(raw, &number, sizeof(Number));
    if (is_big_ != (std::endian::native == std::endian::big))
      std::reverse(raw, raw + sizeof(Number));
    bytes_.insert(bytes_.end(), raw, raw + sizeof(Number));
    return *this;
  }
  Writer& text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    for (const char c : text) put(c);
    return put('\0');
  }
  Writer& header(std::int32_t sec, std::uint32_t nanosec, const std::string& frame_id) {
    return put(sec).put(nanosec).text(frame_id);
  }
  Writer& pose(const Pose& T) {
    const Eigen::Quaterniond q(T.linear());
    for (const double x : {T.translation().x(), T.translation().y(), T.translation().z()}) put(x);
    return put(q.x()).put(q.y()).put(q.z()).put(q.w());
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  bool is_big_;
  Bytes bytes_;
};

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {
    if (bytes.size() < 4 || bytes[0] != std::byte{0} || bytes[1] != std::byte{1}) {
      throw std::runtime_error("no little-endian CDR");
    }
  }

  template <typename Number>
  Number get() {
    while ((next_ - 4) % sizeof(Number) != 0) ++next_;
    if (next_ + sizeof(Number) > bytes_.size()) throw std::runtime_error("CDR ends early");
    Number number;
    std::memcpy(&number, bytes_.data() + next_, sizeof(Number));
    next_ += sizeof(Number);
    return number;
  }
  std::string text() {
    const auto size = get<std::uint32_t>();
    std::string text;
    for (std::uint32_t i = 0; i < size; ++i) text += get<char>();
    if (text.empty() || text.back() != '\0') throw std::runtime_error("a string without an end");
    text.pop_back();
    return text;
  }
  std::uint32_t count() { return get<std::uint32_t>(); }
  Eigen::Vector3d vector() {
    const double x = get<double>(), y = get<double>(), z = get<double>();
    return {x, y, z};
  }
  Pose pose() {
    const Eigen::Vector3d t = vector();
    const double x = get<double>(), y = get<double>(), z = get<double>(), w = get<double>();
    return make_pose(t, Eigen::Quaterniond(w, x, y, z));
  }
  [[nodiscard]] bool is_at_end() const { return next_ == bytes_.size(); }

 private:
  Bytes bytes_;
  std::size_t next_ = 4;
};

/// One point as ouster-ros lays it out, or less of it.
struct CloudPoint {
  float x = 0, y = 0, z = 0;
  std::uint32_t t = 0;
  std::uint16_t ring = 0;
  std::uint32_t range = 0;
};

struct Cloud {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id = "os_lidar";
  std::uint32_t height = 1;
  std::vector<CloudPoint> points;  ///< [height x width]
  bool has_t = true;
  bool ring_is_byte = false;
};

/// A sensor_msgs/PointCloud2 of 48 bytes a point, in one byte order throughout.
inline Bytes write_cloud(const Cloud& cloud, bool is_big) {
  constexpr std::uint32_t kStep = 48;
  Writer writer(is_big);
  const auto width = static_cast<std::uint32_t>(cloud.points.size()) / cloud.height;
  writer.header(cloud.sec, cloud.nanosec, cloud.frame_id).put(cloud.height).put(width);
  const auto field = [&](const char* name, std::uint32_t offset, std::uint8_t type) {
    writer.text(name).put(offset).put(type).put(std::uint32_t{1});
  };
  writer.put(std::uint32_t{cloud.has_t ? 7u : 6u});
  field("x", 0, 7);
  field("y", 4, 7);
  field("z", 8, 7);
  field("intensity", 16, 7);
  if (cloud.has_t) field("t", 20, 6);
  field("ring", 26, cloud.ring_is_byte ? 2 : 4);
  field("range", 32, 6);
  writer.put(is_big).put(kStep).put(kStep * width);
  writer.put(static_cast<std::uint32_t>(cloud.points.size()) * kStep);
  for (const CloudPoint& point : cloud.points) {
    // The point's own numbers lie where its fields say, in the byte order that the message states.
    std::byte raw[kStep] = {};
    const auto set = [&](std::size_t offset, auto number) {
      std::byte swapped[sizeof(number)];
      std::memcpy(swapped, &number, sizeof(number));
      if (is_big != (std::endian::native == std::endian::big)) {
        std::reverse(swapped, swapped + sizeof(number));
      }
      std::memcpy(raw + offset, swapped, sizeof(number));
    };
    set(0, point.x);
    set(4, point.y);
    set(8, point.z);
    set(20, point.t);
    if (cloud.ring_is_byte) {
      set(26, static_cast<std::uint8_t>(point.ring));
    } else {
      set(26, point.ring);
    }
    set(32, point.range);
    for (const std::byte byte : raw) writer.put(byte);
  }
  return writer.put(std::uint8_t{1}).bytes();
}

struct OdometrySample {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  Pose T_O_B = Pose::Identity();
  std::string odometry_frame = "odom";
  std::string body_frame = "body";
};

inline Bytes write_odometry(const OdometrySample& sample, bool is_big) {
  Writer writer(is_big);
  writer.header(sample.sec, sample.nanosec, sample.odometry_frame).text(sample.body_frame);
  writer.pose(sample.T_O_B);
  for (int i = 0; i < 36; ++i) writer.put(0.5 * i);
  for (int i = 0; i < 6; ++i) writer.put(-1.0 * i);
  for (int i = 0; i < 36; ++i) writer.put(0.25 * i);
  return writer.bytes();
}

struct PathPose {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  Pose T_M_N = Pose::Identity();
};

inline Bytes write_path(std::int32_t sec, std::uint32_t nanosec, const std::vector<PathPose>& poses,
                        bool is_big, const std::string& frame_id = "map") {
  Writer writer(is_big);
  writer.header(sec, nanosec, frame_id).put(static_cast<std::uint32_t>(poses.size()));
  for (const PathPose& pose : poses) {
    writer.header(pose.sec, pose.nanosec, frame_id).pose(pose.T_M_N);
  }
  return writer.bytes();
}

struct NamedTransform {
  std::string parent;
  std::string child;
  Pose T_parent_child = Pose::Identity();
};

inline Bytes write_transforms(const std::vector<NamedTransform>& transforms, bool is_big) {
  Writer writer(is_big);
  writer.put(static_cast<std::uint32_t>(transforms.size()));
  for (const NamedTransform& named : transforms) {
    writer.header(1, 2, named.parent).text(named.child).pose(named.T_parent_child);
  }
  return writer.bytes();
}

}  // namespace cloister::cdr
