#pragma once

#include <array>

#include "firmware_interface/ouster/counters.hpp"

namespace cloister::ros2 {

/// What became of ROS 2 messages.
enum class MessageCause {
  kMessages,
  // any message
  kUnknownEncapsulation,
  kMalformedMessage,
  kBadStamp,
  kBadPose,
  kChangedFrame,
  // clouds
  kBadCloudLayout,
  kMissingCloudFields,
  kEmptyCloud,
  kCloudTooLarge,
  kOrganisedCloud,
  kUnorganisedCloud,
  kBeamTable,
  kBeamTableMismatch,
  kReturnOfUnknownBeam,
  // paths
  kEmptyPath,
  kAmbiguousPath,
  // transforms
  kConflictingTransform,
  kCount,
};

constexpr std::array<CounterName, 18> counter_names(MessageCause) {
  return {{{"ros2_messages"},
           {"ros2_unknown_encapsulation", true},  // no, or no plain, CDR
           {"ros2_malformed_message", true},
           {"ros2_bad_stamp", true},
           {"ros2_bad_pose", true},  // not finite, or a quaternion that is no rotation
           {"ros2_changed_frame", true},
           {"cloud_bad_layout", true},  // sizes that contradict each other
           {"cloud_without_fields", true},
           {"cloud_empty", true},
           {"cloud_too_large", true},
           {"clouds_organised"},
           {"clouds_unorganised"},
           {"cloud_beam_tables"},            // how often one was fitted
           {"cloud_beam_table_mismatches"},  // clouds that are not as the beam table has it
           {"cloud_return_of_unknown_beam", true},
           {"path_empty", true},
           {"path_with_equal_stamps", true},  // which pose is which node cannot be told
           {"transform_with_two_parents", true}}};
}

using MessageCounters = Counters<MessageCause>;

}  // namespace cloister::ros2
