#pragma once

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

#include <dds/dds.h>

#include "mapping/core/result.hpp"

/// Small owners around Cyclone's handles. For the sources of this room only: everyone else sees plain types.
namespace cloister {

/// Deletes an entity, and with it what was made on it.
class DdsEntity {
 public:
  DdsEntity() = default;
  explicit DdsEntity(dds_entity_t handle) : handle_(handle) {}
  DdsEntity(DdsEntity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  DdsEntity& operator=(DdsEntity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~DdsEntity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  [[nodiscard]] dds_entity_t handle() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

/// A topic of Cloister's own and how it is sent.
struct TopicKind {
  const char* name;
  const dds_topic_descriptor_t* descriptor;
  std::int32_t depth;         ///< samples kept, on both sides
  bool is_latched = false;    ///< who comes late gets the last one
  bool is_shareable = false;  ///< may go through shared memory
};

/// All topics, in one place.
extern const TopicKind kScanTopic, kOdometryTopic, kGraphTopic, kSensorTopic, kSubmapsTopic,
    kDiagnosticsTopic, kSaveMapTopic, kSaveMapReplyTopic, kHullTopic, kHullReplyTopic, kBlocksTopic,
    kBlocksReplyTopic, kResetTopic, kResetReplyTopic;

/// Makes ends of topics on one participant and remembers the first failure.
class EndMaker {
 public:
  explicit EndMaker(dds_entity_t participant) : participant_(participant) {}
  [[nodiscard]] DdsEntity reader(const TopicKind& kind);
  [[nodiscard]] DdsEntity writer(const TopicKind& kind);
  /// An end of any topic.
  [[nodiscard]] DdsEntity end(const std::string& name, const dds_topic_descriptor_t& descriptor,
                              const dds_qos_t* qos, bool is_reader);
  [[nodiscard]] Result<void> outcome() const;

 private:
  [[nodiscard]] DdsEntity make(const TopicKind& kind, bool is_reader);

  dds_entity_t participant_;
  std::string failed_;
  dds_return_t error_ = 0;
};

/// Lets a waitset end its wait while the reader has something.
void attach_reader(dds_entity_t waitset, const DdsEntity& reader);

/// Waits until each writer has a reader, and then until the other side, which learns of the match on its own, knows.
/// @return false when the time was over first
[[nodiscard]] bool wait_for_readers(std::initializer_list<const DdsEntity*> writers,
                                    std::chrono::milliseconds timeout);

/// Takes one sample of a type of fixed size, or one whose members `release` gives back.
template <typename Message>
bool take_fixed(const DdsEntity& reader, Message& message) {
  void* samples[1] = {&message};
  dds_sample_info_t info;
  while (dds_take(reader.handle(), samples, &info, 1, 1) == 1) {
    if (info.valid_data) return true;  // else only news about the writer
  }
  return false;
}

/// Takes one sample of a type with strings or sequences and shows it to `use`.
/// @param written  set to when it was written, by the writer's clock
template <typename Message, typename Use>
bool take_loaned(const DdsEntity& reader, Use&& use, dds_time_t* written = nullptr) {
  while (true) {
    void* samples[1] = {nullptr};
    dds_sample_info_t info;
    if (dds_take(reader.handle(), samples, &info, 1, 1) != 1) return false;
    const bool is_valid = info.valid_data;
    if (written != nullptr) *written = info.source_timestamp;
    if (is_valid) use(*static_cast<const Message*>(samples[0]));
    (void)dds_return_loan(reader.handle(), samples, 1);
    if (is_valid) return true;
  }
}

}  // namespace cloister
