#include "firmware_interface/dds/topic_ends.hpp"

#include <cloister_native.h>

#include <algorithm>
#include <memory>
#include <string>

namespace cloister {
namespace {

// A writer that finds no room waits at most this long: a robot's odometry must not stand still for a slow reader.
constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);

}  // namespace

const TopicKind kScanTopic{"cloister/scan", &cloister_wire_OrganisedScan_desc, 32, false, true};
const TopicKind kOdometryTopic{"cloister/odometry", &cloister_wire_Odometry_desc, 256};
const TopicKind kGraphTopic{"cloister/graph", &cloister_wire_GraphPart_desc, 1024};
const TopicKind kSensorTopic{"cloister/sensor", &cloister_wire_SensorDescription_desc, 1, true};
const TopicKind kSubmapsTopic{"cloister/submaps", &cloister_wire_SubmapList_desc, 1, true};
const TopicKind kDiagnosticsTopic{"cloister/diagnostics", &cloister_wire_Diagnostics_desc, 1};
const TopicKind kSaveMapTopic{"cloister/save_map", &cloister_wire_SaveMapRequest_desc, 8};
const TopicKind kSaveMapReplyTopic{"cloister/save_map_reply", &cloister_wire_SaveMapReply_desc, 8};
const TopicKind kHullTopic{"cloister/check_hull", &cloister_wire_HullRequest_desc, 8};
const TopicKind kHullReplyTopic{"cloister/check_hull_reply", &cloister_wire_HullReply_desc, 8};
const TopicKind kBlocksTopic{"cloister/get_blocks", &cloister_wire_BlocksRequest_desc, 8};
const TopicKind kBlocksReplyTopic{"cloister/get_blocks_reply", &cloister_wire_BlocksReply_desc, 8};
const TopicKind kResetTopic{"cloister/reset", &cloister_wire_ResetRequest_desc, 8};
const TopicKind kResetReplyTopic{"cloister/reset_reply", &cloister_wire_ResetReply_desc, 8};

DdsEntity EndMaker::make(const TopicKind& kind, bool is_reader) {
  const std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(dds_create_qos(),
                                                                  &dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMaxBlocking);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kind.depth);
  if (kind.is_latched) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, kind.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  // An end that ignores its own participant's keeps off shared memory: of no use for small samples, and who comes late
  // gets nothing latched from there.
  if (!kind.is_shareable) dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);

  return end(kind.name, *kind.descriptor, qos.get(), is_reader);
}

DdsEntity EndMaker::end(const std::string& name, const dds_topic_descriptor_t& descriptor,
                        const dds_qos_t* qos, bool is_reader) {
  if (!failed_.empty()) return {};
  const auto note = [&](dds_entity_t handle) {
    if (handle < 0 && failed_.empty()) {
      failed_ = name;
      error_ = handle;
    }
    return handle;
  };
  const dds_entity_t topic =
      note(dds_create_topic(participant_, &descriptor, name.c_str(), nullptr, nullptr));
  if (topic < 0) return {};
  const dds_entity_t end = note(is_reader ? dds_create_reader(participant_, topic, qos, nullptr)
                                          : dds_create_writer(participant_, topic, qos, nullptr));
  dds_delete(topic);  // the end holds it
  return end < 0 ? DdsEntity() : DdsEntity(end);
}

DdsEntity EndMaker::reader(const TopicKind& kind) { return make(kind, true); }
DdsEntity EndMaker::writer(const TopicKind& kind) { return make(kind, false); }

Result<void> EndMaker::outcome() const {
  if (failed_.empty()) return {};
  return fail(ErrorKind::kResource,
              "topic " + failed_ + ": cannot be made: " + dds_strretcode(-error_));
}

void attach_reader(dds_entity_t waitset, const DdsEntity& reader) {
  const dds_entity_t condition = dds_create_readcondition(reader.handle(), DDS_ANY_STATE);
  (void)dds_waitset_attach(waitset, condition, 0);
}

bool wait_for_readers(std::initializer_list<const DdsEntity*> writers,
                      std::chrono::milliseconds timeout) {
  const dds_time_t deadline = dds_time() + DDS_MSECS(timeout.count());
  const auto is_read = [](const DdsEntity* writer) {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer->handle(), &status) == 0 &&
           status.current_count > 0;
  };
  while (!std::all_of(writers.begin(), writers.end(), is_read)) {
    if (dds_time() >= deadline) return false;
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_sleepfor(DDS_MSECS(300));
  return true;
}

}  // namespace cloister
