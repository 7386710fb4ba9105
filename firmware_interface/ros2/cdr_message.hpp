#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "firmware_interface/ros2/message_counters.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"

namespace cloister::ros2 {

/// The work behind Message, for any type.
[[nodiscard]] bool decode_cdr(std::span<const std::byte> cdr, const dds_topic_descriptor_t& type,
                              std::vector<std::byte>& scratch, void* sample,
                              MessageCounters& counters);
[[nodiscard]] std::vector<std::byte> encode_cdr(const dds_topic_descriptor_t& type,
                                                const void* sample);
void free_contents(const dds_topic_descriptor_t& type, void* sample);

/// A message as the IDL compiler lays it out, with everything it points to.
///
/// CDR here is what travels in a DDS sample and lies in a rosbag2: four bytes that say how the rest is encoded (plain
/// CDR in either byte order; bytes 2 and 3 are options and ignored), then the members. What stands behind the last
/// member is ignored, since some middlewares pad.
///
/// Threads: one at a time. Memory: strings and sequences of the message before are used again.
template <typename Topic>
class Message {
 public:
  Message() = default;
  ~Message() { free_contents(descriptor<Topic>(), &value_); }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
  Message(Message&& other) noexcept : value_(std::exchange(other.value_, Topic{})) {}
  Message& operator=(Message&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }

  [[nodiscard]] Topic& operator*() { return value_; }
  [[nodiscard]] const Topic& operator*() const { return value_; }
  [[nodiscard]] Topic* operator->() { return &value_; }
  [[nodiscard]] const Topic* operator->() const { return &value_; }

  /// Reads a message, whoever wrote it: every length is checked before it is believed.
  /// @return false, counted, and the value as it was, when these bytes are no such message
  [[nodiscard]] bool decode(std::span<const std::byte> cdr, MessageCounters& counters) {
    return decode_cdr(cdr, descriptor<Topic>(), scratch_, &value_, counters);
  }

  /// The message in little-endian CDR.
  [[nodiscard]] std::vector<std::byte> encode() const {
    return encode_cdr(descriptor<Topic>(), &value_);
  }

 private:
  Topic value_ = {};
  std::vector<std::byte> scratch_;
};

}  // namespace cloister::ros2
