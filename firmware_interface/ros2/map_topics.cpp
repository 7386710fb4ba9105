#include "firmware_interface/ros2/map_topics.hpp"

#include <utility>

#include <dds/dds.h>

#include "firmware_interface/dds/topic_ends.hpp"
#include "firmware_interface/ros2/map_messages.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "firmware_interface/ros2/topic_qos.hpp"

namespace cloister::ros2 {
namespace {

template <typename Topic>
DdsEntity writer(EndMaker& make, const char* ros_name, const TopicQos& profile) {
  const QosPtr qos = make_qos(profile);
  // The mapper waits for nobody.
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  return make.end(dds_topic_name(ros_name), descriptor<Topic>(), qos.get(), false);
}

}  // namespace

struct MapTopics::Ends {
  DdsEntity submaps, occupied, octomap, transforms, diagnostics, octomap_request;
  std::int64_t num_refused = 0;

  template <typename Topic>
  void write(const DdsEntity& writer, const Message<Topic>& message) {
    if (dds_write(writer.handle(), &*message) != DDS_RETCODE_OK) ++num_refused;
  }
};

MapTopics::MapTopics(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
MapTopics::MapTopics(MapTopics&&) noexcept = default;
MapTopics& MapTopics::operator=(MapTopics&&) noexcept = default;
MapTopics::~MapTopics() = default;

Result<MapTopics> MapTopics::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  ends->submaps = writer<MarkerArray>(make, "/cloister/submaps", kMarkersOutput);
  ends->occupied = writer<PointCloud2>(make, "/cloister/occupied", kOccupiedCloudOutput);
  ends->octomap = writer<OctomapMessage>(make, "/cloister/octomap", kOctomapOutput);
  ends->transforms = writer<TFMessage>(make, "/tf", kTransformsOutput);
  ends->diagnostics = writer<DiagnosticArray>(make, "/diagnostics", kDiagnosticsOutput);
  ends->octomap_request = make.end(dds_topic_name("/cloister/request_octomap"), descriptor<Empty>(),
                                   make_qos(kRequestInput).get(), true);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  return MapTopics(std::move(ends));
}

void MapTopics::publish_submaps(const MessageHeader& header, std::span<const SubmapMarker> submaps,
                                std::span<const LoopMarker> loops) {
  ends_->write(ends_->submaps, markers_message(header, submaps, loops));
}

void MapTopics::publish_occupied(const MessageHeader& header, const MapView& map) {
  ends_->write(ends_->occupied, occupied_cloud_message(header, map));
}

void MapTopics::publish_octomap(const MessageHeader& header, double voxel_size_m,
                                std::string_view data) {
  ends_->write(ends_->octomap, octomap_message(header, voxel_size_m, data, false));
}

void MapTopics::publish_transform(const MessageHeader& header, std::string_view child_frame_id,
                                  const Pose& T_parent_child) {
  ends_->write(ends_->transforms, transform_message(header, child_frame_id, T_parent_child));
}

void MapTopics::publish(SensorTime stamp, const Diagnostic& diagnostic) {
  ends_->write(ends_->diagnostics, diagnostics_message(stamp, std::span(&diagnostic, 1)));
}

MapTopics::Readers MapTopics::readers_of_occupied() {
  dds_publication_matched_status_t status{};
  if (dds_get_publication_matched_status(ends_->occupied.handle(), &status) != 0) return {};
  return {status.current_count > 0, status.total_count_change > 0};
}

bool MapTopics::take_octomap_request() {
  bool is_asked = false;
  for (Empty request; take_fixed(ends_->octomap_request, request);) is_asked = true;
  return is_asked;
}

std::int64_t MapTopics::num_refused() const { return ends_->num_refused; }

}  // namespace cloister::ros2
