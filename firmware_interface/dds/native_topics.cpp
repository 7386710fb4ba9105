#include "firmware_interface/dds/native_topics.hpp"

#include <cloister_native.h>

#include <dds/dds.h>
#include <dds/ddsc/dds_loan_api.h>
#include <dds/ddsi/ddsi_serdata.h>
extern "C" {
#include <dds/ddsi/ddsi_shm_transport.h>
}

#include "firmware_interface/dds/topic_ends.hpp"
#include "firmware_interface/dds/wire_types.hpp"

namespace cloister {

struct MapperTopics::Ends {
  DdsEntity scan, odometry, graph, sensor, save;
  DdsEntity submaps, diagnostics, save_reply;
  DdsEntity waitset;
  Counters<TopicCause> counters;
  GraphParts parts{counters};
  std::unique_ptr<cloister_wire_OrganisedScan> copy =
      std::make_unique<cloister_wire_OrganisedScan>();
  bool stays_on_host = false;
  std::optional<std::int64_t> scan_written_ns;
  bool has_scan = false;
  std::uint32_t last_scan_number = 0;

  void note_number(std::uint32_t number) {
    // A smaller number is that of a publisher that began anew.
    if (has_scan && number > last_scan_number + 1)
      counters.add(TopicCause::kScansLost, number - last_scan_number - 1);
    has_scan = true;
    last_scan_number = number;
  }
};

MapperTopics::MapperTopics(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
MapperTopics::MapperTopics(MapperTopics&&) noexcept = default;
MapperTopics& MapperTopics::operator=(MapperTopics&&) noexcept = default;
MapperTopics::~MapperTopics() = default;

Result<MapperTopics> MapperTopics::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  ends->stays_on_host = link.stays_on_host();
  EndMaker make(link.participant());
  ends->scan = make.reader(kScanTopic);
  ends->odometry = make.reader(kOdometryTopic);
  ends->graph = make.reader(kGraphTopic);
  ends->sensor = make.reader(kSensorTopic);
  ends->save = make.reader(kSaveMapTopic);
  ends->submaps = make.writer(kSubmapsTopic);
  ends->diagnostics = make.writer(kDiagnosticsTopic);
  ends->save_reply = make.writer(kSaveMapReplyTopic);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  ends->waitset = DdsEntity(dds_create_waitset(link.participant()));
  for (const DdsEntity* reader :
       {&ends->scan, &ends->odometry, &ends->graph, &ends->sensor, &ends->save}) {
    attach_reader(ends->waitset.handle(), *reader);
  }
  return MapperTopics(std::move(ends));
}

void MapperTopics::wait(std::chrono::milliseconds timeout) {
  (void)dds_waitset_wait(ends_->waitset.handle(), nullptr, 0, DDS_MSECS(timeout.count()));
}

bool MapperTopics::take(SensorDescription& sensor) {
  return take_loaned<cloister_wire_SensorDescription>(
      ends_->sensor, [&](const cloister_wire_SensorDescription& message) {
        sensor.metadata_json = message.metadata_json;
        sensor.T_pose_sensor = from_wire(message.pose_T_pose_sensor);
      });
}

bool MapperTopics::take(OdometrySample& sample) {
  cloister_wire_Odometry message;
  if (!take_fixed(ends_->odometry, message)) return false;
  sample = {message.session, {SensorTime{message.stamp_ns}, from_wire(message.pose_T_O_B)}};
  return true;
}

bool MapperTopics::take(GraphUpdate& update) {
  const auto part = std::make_unique<cloister_wire_GraphPart>();
  while (take_fixed(ends_->graph, *part)) {
    if (auto whole = ends_->parts.add(*part)) {
      update = std::move(*whole);
      return true;
    }
  }
  return false;
}

bool MapperTopics::take(Scan& scan, int num_beams, int num_columns) {
  while (true) {
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info;
    if (dds_takecdr(ends_->scan.handle(), &data, 1, &info, DDS_ANY_STATE) != 1) return false;
    const std::unique_ptr<ddsi_serdata, decltype(&ddsi_serdata_unref)> holder(data,
                                                                              &ddsi_serdata_unref);
    if (!info.valid_data) continue;
    const cloister_wire_OrganisedScan* message = ends_->copy.get();
    ends_->scan_written_ns.reset();
    if (ends_->stays_on_host || data->iox_chunk != nullptr)
      ends_->scan_written_ns = info.source_timestamp;
    if (data->iox_chunk != nullptr &&
        shm_get_data_state(data->iox_chunk) == IOX_CHUNK_CONTAINS_RAW_DATA) {
      message = static_cast<const cloister_wire_OrganisedScan*>(data->iox_chunk);
      ends_->counters.add(TopicCause::kScansInPlace);
    } else if (ddsi_serdata_to_sample(data, ends_->copy.get(), nullptr, nullptr)) {
      ends_->counters.add(TopicCause::kScansCopied);
    } else {
      ends_->counters.add(TopicCause::kScanMalformed);
      continue;
    }
    ends_->note_number(message->scan_number);
    if (from_wire(*message, num_beams, num_columns, scan)) return true;
    ends_->counters.add(TopicCause::kScanMalformed);
  }
}

std::optional<std::int64_t> MapperTopics::scan_written_ns() const { return ends_->scan_written_ns; }

bool MapperTopics::take(SaveMapRequest& request) {
  cloister_wire_SaveMapRequest message;
  if (!take_fixed(ends_->save, message)) return false;
  request.id = message.id;
  return true;
}

void MapperTopics::publish(const SubmapList& list) {
  std::vector<cloister_wire_SubmapState> states(list.submaps.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const SubmapState& from = list.submaps[i];
    states[i] = {from.id, from.version, from.is_active, from.root_node,
                 {},      from.blocks,  from.bytes};
    to_wire(from.T_M_S, states[i].pose_T_M_S);
  }
  cloister_wire_SubmapList message{};
  message.stamp_ns = list.stamp.ns;
  message.graph_revision = list.graph_revision;
  message.submaps._length = message.submaps._maximum = static_cast<std::uint32_t>(states.size());
  message.submaps._buffer = states.data();
  (void)dds_write(ends_->submaps.handle(), &message);
}

void MapperTopics::publish(const Diagnostics& diagnostics) {
  std::vector<cloister_wire_NamedValue> values;
  // Only read by dds_write, which wants it writable all the same.
  for (const auto& [name, value] : diagnostics.values)
    values.push_back({const_cast<char*>(name.c_str()), value});
  cloister_wire_Diagnostics message{};
  message.stamp_ns = diagnostics.stamp.ns;
  message.values._length = message.values._maximum = static_cast<std::uint32_t>(values.size());
  message.values._buffer = values.data();
  (void)dds_write(ends_->diagnostics.handle(), &message);
}

void MapperTopics::publish(const SaveMapReply& reply) {
  cloister_wire_SaveMapReply message{reply.id, reply.is_saved,
                                     const_cast<char*>(reply.message.c_str()),
                                     const_cast<char*>(reply.path.c_str()), reply.bytes};
  (void)dds_write(ends_->save_reply.handle(), &message);
}

const Counters<TopicCause>& MapperTopics::counters() const { return ends_->counters; }

struct RobotTopics::Ends {
  DdsEntity scan, odometry, graph, sensor, save;
  DdsEntity submaps, diagnostics, save_reply;
  std::unique_ptr<cloister_wire_OrganisedScan> copy =
      std::make_unique<cloister_wire_OrganisedScan>();
  std::uint32_t num_scans = 0;
};

RobotTopics::RobotTopics(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
RobotTopics::RobotTopics(RobotTopics&&) noexcept = default;
RobotTopics& RobotTopics::operator=(RobotTopics&&) noexcept = default;
RobotTopics::~RobotTopics() = default;

Result<RobotTopics> RobotTopics::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  ends->scan = make.writer(kScanTopic);
  ends->odometry = make.writer(kOdometryTopic);
  ends->graph = make.writer(kGraphTopic);
  ends->sensor = make.writer(kSensorTopic);
  ends->save = make.writer(kSaveMapTopic);
  ends->submaps = make.reader(kSubmapsTopic);
  ends->diagnostics = make.reader(kDiagnosticsTopic);
  ends->save_reply = make.reader(kSaveMapReplyTopic);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  return RobotTopics(std::move(ends));
}

bool RobotTopics::wait_for_mapper(std::chrono::milliseconds timeout) {
  return wait_for_readers({&ends_->scan, &ends_->odometry, &ends_->graph}, timeout);
}

bool RobotTopics::publish(const SensorDescription& sensor) {
  cloister_wire_SensorDescription message{{}, const_cast<char*>(sensor.metadata_json.c_str())};
  to_wire(sensor.T_pose_sensor, message.pose_T_pose_sensor);
  return dds_write(ends_->sensor.handle(), &message) == DDS_RETCODE_OK;
}

bool RobotTopics::publish(const OdometrySample& sample) {
  cloister_wire_Odometry message{sample.session, sample.pose.stamp.ns, {}};
  to_wire(sample.pose.T_O_B, message.pose_T_O_B);
  return dds_write(ends_->odometry.handle(), &message) == DDS_RETCODE_OK;
}

bool RobotTopics::publish(const GraphUpdate& update) {
  for (const cloister_wire_GraphPart& part : to_wire(update)) {
    if (dds_write(ends_->graph.handle(), &part) != DDS_RETCODE_OK) return false;
  }
  return true;
}

bool RobotTopics::publish(const Scan& scan, int num_beams, int num_columns) {
  if (scan.ranges_mm.size() > kMaxTopicPixels || scan.column_valid.size() > kMaxTopicColumns)
    return false;
  void* loan = nullptr;
  const bool is_shared = dds_is_loan_available(ends_->scan.handle()) &&
                         dds_loan_sample(ends_->scan.handle(), &loan) == DDS_RETCODE_OK &&
                         loan != nullptr;
  auto& message = is_shared ? *static_cast<cloister_wire_OrganisedScan*>(loan) : *ends_->copy;
  to_wire(scan, num_beams, num_columns, ends_->num_scans++, message);
  return dds_write(ends_->scan.handle(), &message) == DDS_RETCODE_OK;
}

bool RobotTopics::publish(const SaveMapRequest& request) {
  cloister_wire_SaveMapRequest message{request.id};
  return dds_write(ends_->save.handle(), &message) == DDS_RETCODE_OK;
}

bool RobotTopics::take(SubmapList& list) {
  return take_loaned<cloister_wire_SubmapList>(
      ends_->submaps, [&](const cloister_wire_SubmapList& message) {
        list = {SensorTime{message.stamp_ns}, message.graph_revision, {}};
        for (std::uint32_t i = 0; i < message.submaps._length; ++i) {
          const cloister_wire_SubmapState& from = message.submaps._buffer[i];
          list.submaps.push_back({from.id, from.version, from.is_active, from.root_node,
                                  from_wire(from.pose_T_M_S), from.blocks, from.bytes});
        }
      });
}

bool RobotTopics::take(Diagnostics& diagnostics) {
  return take_loaned<cloister_wire_Diagnostics>(
      ends_->diagnostics, [&](const cloister_wire_Diagnostics& message) {
        diagnostics = {SensorTime{message.stamp_ns}, {}};
        for (std::uint32_t i = 0; i < message.values._length; ++i) {
          diagnostics.values.emplace_back(message.values._buffer[i].name,
                                          message.values._buffer[i].value);
        }
      });
}

bool RobotTopics::take(SaveMapReply& reply) {
  return take_loaned<cloister_wire_SaveMapReply>(
      ends_->save_reply, [&](const cloister_wire_SaveMapReply& message) {
        reply = {message.id, message.is_saved, message.message, message.path, message.bytes};
      });
}

}  // namespace cloister
