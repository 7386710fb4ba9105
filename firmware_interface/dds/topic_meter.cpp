#include "firmware_interface/dds/topic_meter.hpp"

#include <map>
#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include "firmware_interface/dds/topic_ends.hpp"

namespace cloister {

struct TopicMeter::Ends {
  struct Own {
    DdsEntity reader;
    std::string topic;
    std::uint64_t count = 0;
    std::uint64_t bytes = 0;
  };
  std::vector<Own> own;
  DdsEntity publications;
  std::map<std::string, std::string> types;  ///< by topic, of those that somebody publishes

  void count(Own& topic) {
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info;
    while (dds_takecdr(topic.reader.handle(), &data, 1, &info, DDS_ANY_STATE) == 1) {
      if (info.valid_data) {
        ++topic.count;
        topic.bytes += ddsi_serdata_size(data);
      }
      ddsi_serdata_unref(data);
    }
  }
};

TopicMeter::TopicMeter(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
TopicMeter::TopicMeter(TopicMeter&&) noexcept = default;
TopicMeter& TopicMeter::operator=(TopicMeter&&) noexcept = default;
TopicMeter::~TopicMeter() = default;

Result<TopicMeter> TopicMeter::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  for (const TopicKind* kind :
       {&kScanTopic, &kOdometryTopic, &kGraphTopic, &kSensorTopic, &kSubmapsTopic,
        &kDiagnosticsTopic, &kSaveMapTopic, &kSaveMapReplyTopic, &kHullTopic, &kHullReplyTopic,
        &kBlocksTopic, &kBlocksReplyTopic, &kResetTopic, &kResetReplyTopic}) {
    ends->own.push_back({make.reader(*kind), kind->name, 0, 0});
  }
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  ends->publications = DdsEntity(
      dds_create_reader(link.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  return TopicMeter(std::move(ends));
}

void TopicMeter::poll(std::chrono::milliseconds timeout) {
  dds_sleepfor(DDS_MSECS(timeout.count()));
  for (Ends::Own& topic : ends_->own) ends_->count(topic);
  while (take_loaned<dds_builtintopic_endpoint_t>(
      ends_->publications, [&](const dds_builtintopic_endpoint_t& endpoint) {
        ends_->types[endpoint.topic_name] = endpoint.type_name;
      })) {
  }
}

std::vector<TopicMeter::Row> TopicMeter::rows() const {
  std::vector<Row> rows;
  for (const auto& [topic, type] : ends_->types) {
    Row row{topic, type, false, 0, 0};
    for (const Ends::Own& own : ends_->own) {
      if (own.topic != topic) continue;
      row.is_measured = true;
      row.count = own.count;
      row.bytes = own.bytes;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace cloister
