#include "firmware_interface/ros2/driver_topics.hpp"

#include <utility>

#include <dds/dds.h>

#include "firmware_interface/dds/topic_ends.hpp"
#include "firmware_interface/ros2/driver_messages.hpp"
#include "firmware_interface/ros2/map_messages.hpp"
#include "firmware_interface/ros2/odometry_message.hpp"
#include "firmware_interface/ros2/path_message.hpp"
#include "firmware_interface/ros2/point_cloud_message.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "firmware_interface/ros2/static_transforms.hpp"
#include "firmware_interface/ros2/topic_qos.hpp"

namespace cloister::ros2 {
namespace {

static_assert(DriverListener::kMaxColumns == PointCloudDecoder::kMaxColumns);

// A publisher's frames and ids do not say when it began anew: to the mapper it is one run.
constexpr std::uint64_t kSession = 1;

template <typename Topic>
DdsEntity reader(EndMaker& make, const std::string& ros_name, const TopicQos& profile) {
  if (ros_name.empty()) return {};
  return make.end(dds_topic_name(ros_name), descriptor<Topic>(), make_qos(profile).get(), true);
}

/// Offers to send again what is lost, so that readers of either kind hear it, and waits for slow ones: a recording has
/// time.
template <typename Topic>
DdsEntity writer(EndMaker& make, const std::string& ros_name, const TopicQos& profile) {
  if (ros_name.empty()) return {};
  const QosPtr qos = make_qos(profile);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(5));
  return make.end(dds_topic_name(ros_name), descriptor<Topic>(), qos.get(), false);
}

}  // namespace

struct DriverListener::Ends {
  explicit Ends(const Options& options)
      : has_odometry(!options.names.odometry.empty()),
        path_topic(options.names.path),
        clouds_decoder(options.max_points, !has_odometry) {}

  DdsEntity points, odometry, path, static_transforms;
  DdsEntity waitset;
  bool has_odometry;
  std::string path_topic;
  PointCloudDecoder clouds_decoder;
  OdometryDecoder odometry_decoder;
  PathDecoder path_decoder;
  StaticTransforms transforms;
  bool has_cloud = false;
  bool stays_on_host = false;
  dds_time_t scan_written_ns = 0;
  std::uint64_t num_paths = 0;
  MessageCounters counters;

  /// Takes messages until `use` can make something of one.
  template <typename Topic, typename Use>
  bool take(const DdsEntity& reader, Use&& use, dds_time_t* written = nullptr) {
    bool is_used = false;
    const auto count_and_use = [&](const Topic& message) {
      counters.add(MessageCause::kMessages);
      is_used = use(message);
    };
    while (!is_used && take_loaned<Topic>(reader, count_and_use, written)) {
    }
    return is_used;
  }
};

DriverListener::DriverListener(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
DriverListener::DriverListener(DriverListener&&) noexcept = default;
DriverListener& DriverListener::operator=(DriverListener&&) noexcept = default;
DriverListener::~DriverListener() = default;

Result<DriverListener> DriverListener::open(const DdsLink& link, const Options& options) {
  const DriverTopicNames& names = options.names;
  if (names.points.empty() || (names.odometry.empty() && names.path.empty())) {
    return fail(
        ErrorKind::kUsage,
        "ros2.points_topic and one of ros2.odometry_topic and ros2.path_topic must be named");
  }
  auto ends = std::make_unique<Ends>(options);
  ends->stays_on_host = link.stays_on_host();
  TopicQos points_profile = kPointCloudInput, odometry_profile = kOdometryInput;
  points_profile.is_reliable = odometry_profile.is_reliable = options.is_reliable;
  EndMaker make(link.participant());
  ends->points = reader<PointCloud2>(make, names.points, points_profile);
  ends->odometry = reader<Odometry>(make, names.odometry, odometry_profile);
  ends->path = reader<Path>(make, names.path, kPathInput);
  ends->static_transforms =
      reader<TFMessage>(make, names.static_transforms, kStaticTransformsInput);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  ends->waitset = DdsEntity(dds_create_waitset(link.participant()));
  for (const DdsEntity* end :
       {&ends->points, &ends->odometry, &ends->path, &ends->static_transforms}) {
    if (end->handle() > 0) attach_reader(ends->waitset.handle(), *end);
  }
  return DriverListener(std::move(ends));
}

void DriverListener::wait(std::chrono::milliseconds timeout) {
  (void)dds_waitset_wait(ends_->waitset.handle(), nullptr, 0, DDS_MSECS(timeout.count()));
}

bool DriverListener::take(OdometrySample& sample) {
  return ends_->take<Odometry>(ends_->odometry, [&](const Odometry& message) {
    const auto pose = ends_->odometry_decoder.pose(message, ends_->counters);
    if (pose) sample = {kSession, *pose};
    return pose.has_value();
  });
}

bool DriverListener::take(GraphUpdate& update) {
  return ends_->take<Path>(ends_->path, [&](const Path& message) {
    auto graph = ends_->path_decoder.graph(message, ends_->counters);
    if (graph) update = {kSession, ++ends_->num_paths, 0, std::move(*graph)};
    return graph.has_value();
  });
}

bool DriverListener::take(Scan& scan) {
  const auto decode = [&](const PointCloud2& message) {
    return ends_->clouds_decoder.scan(message, ends_->counters, scan);
  };
  const bool is_taken = ends_->take<PointCloud2>(ends_->points, decode, &ends_->scan_written_ns);
  ends_->has_cloud |= is_taken;
  return is_taken;
}

std::optional<std::int64_t> DriverListener::scan_written_ns() const {
  return ends_->stays_on_host ? std::optional(ends_->scan_written_ns) : std::nullopt;
}

std::optional<Pose> DriverListener::T_body_cloud() {
  (void)ends_->take<TFMessage>(ends_->static_transforms, [&](const TFMessage& message) {
    ends_->transforms.add(message, ends_->counters);
    return false;  // the next one as well
  });
  if (!ends_->has_odometry) return Pose::Identity();
  const std::string& body = ends_->odometry_decoder.body_frame();
  if (!ends_->has_cloud || body.empty()) return std::nullopt;
  return ends_->transforms.find(body, ends_->clouds_decoder.frame());
}

const std::string& DriverListener::odometry_frame() const {
  return ends_->odometry_decoder.odometry_frame();
}

std::string DriverListener::warning() const {
  if (ends_->num_paths == 0) return {};
  return warning_without_covariances(ends_->path_topic);
}

const MessageCounters& DriverListener::counters() const { return ends_->counters; }

struct DriverTopics::Ends {
  DdsEntity points, odometry, path, static_transforms;
};

DriverTopics::DriverTopics(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
DriverTopics::DriverTopics(DriverTopics&&) noexcept = default;
DriverTopics& DriverTopics::operator=(DriverTopics&&) noexcept = default;
DriverTopics::~DriverTopics() = default;

Result<DriverTopics> DriverTopics::open(const DdsLink& link, const DriverTopicNames& names) {
  if (names.points.empty() || names.odometry.empty() || names.path.empty()) {
    return fail(ErrorKind::kUsage,
                "ros2.points_topic, ros2.odometry_topic and ros2.path_topic must be named to play");
  }
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  ends->points = writer<PointCloud2>(make, names.points, kPointCloudInput);
  ends->odometry = writer<Odometry>(make, names.odometry, kOdometryInput);
  ends->path = writer<Path>(make, names.path, kPathInput);
  ends->static_transforms =
      writer<TFMessage>(make, names.static_transforms, kStaticTransformsInput);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  return DriverTopics(std::move(ends));
}

bool DriverTopics::wait_for_mapper(std::chrono::milliseconds timeout) {
  return wait_for_readers(
      {&ends_->points, &ends_->odometry, &ends_->path, &ends_->static_transforms}, timeout);
}

bool DriverTopics::publish(const StampedPose& odometry) {
  const auto message = odometry_message(odometry, kOdometryFrame, kBodyFrame);
  return dds_write(ends_->odometry.handle(), &*message) == DDS_RETCODE_OK;
}

bool DriverTopics::publish(const PoseGraph& graph) {
  const auto message = path_message(graph, kMapFrame);
  return dds_write(ends_->path.handle(), &*message) == DDS_RETCODE_OK;
}

bool DriverTopics::publish(const Scan& scan) {
  const auto message = scan_message(scan, kSensorFrame);
  return dds_write(ends_->points.handle(), &*message) == DDS_RETCODE_OK;
}

bool DriverTopics::publish_sensor_pose(const Pose& T_body_sensor) {
  const auto message = transform_message({SensorTime{}, kBodyFrame}, kSensorFrame, T_body_sensor);
  return dds_write(ends_->static_transforms.handle(), &*message) == DDS_RETCODE_OK;
}

}  // namespace cloister::ros2
