#include "firmware_interface/mission/mission_reader.hpp"

#include <system_error>

#include "firmware_interface/files/pcd_file.hpp"
#include "firmware_interface/files/tum_file.hpp"
#include "firmware_interface/ouster/ouster_geometry.hpp"
#include "firmware_interface/ros2/rosbag_mission.hpp"

namespace cloister {
namespace {

/// A mission directory may keep the recording that it was made from.
bool is_recording(const std::filesystem::path& path) {
  std::error_code error;
  return ros2::RosbagFile::is_one(path) && !std::filesystem::exists(path / "lidar.pcap", error) &&
         !std::filesystem::exists(path / "individual_clouds", error);
}

}  // namespace

MissionReader::MissionReader(MissionFolder folder, const Config& config)
    : folder_(std::move(folder)), config_(config) {}

MissionReader::~MissionReader() = default;

const std::string& MissionReader::name() const { return bag_ ? bag_->name() : folder_.name; }

Result<std::unique_ptr<MissionReader>> MissionReader::open(const std::filesystem::path& path,
                                                           const Config& config) {
  if (is_recording(path)) {
    auto bag = ros2::RosbagMission::open(path, static_cast<std::size_t>(config.scan.max_points));
    if (!bag) return tl::unexpected(bag.error());
    std::unique_ptr<MissionReader> reader(new MissionReader({}, config));
    reader->open_bag(std::move(*bag));
    return reader;
  }
  auto folder = open_mission(path);
  if (!folder) return tl::unexpected(folder.error());
  std::unique_ptr<MissionReader> reader(new MissionReader(std::move(*folder), config));
  if (auto opened = reader->open_files(); !opened) return tl::unexpected(opened.error());
  return reader;
}

Result<void> MissionReader::open_files() {
  Pose T_B_L = Pose::Identity();
  if (folder_.variant == MissionVariant::kPackets) {
    auto metadata = load_metadata(folder_.metadata_path);
    if (!metadata) return tl::unexpected(metadata.error());
    metadata_ = std::move(*metadata);
    geometry_ = make_geometry(*metadata_);
    auto packets = PcapSource::open(folder_.packets_path);
    if (!packets) return tl::unexpected(packets.error());
    packets_.emplace(std::move(*packets));
    assembler_.emplace(*metadata_);
    if (folder_.pose_frame == PoseFrame::kLidar) T_B_L = metadata_->T_sensor_lidar.inverse();
  }
  if (folder_.T_pose_sensor) T_B_L = *folder_.T_pose_sensor;
  placer_ = ScanPlacer(config_.scan, T_B_L);
  if (folder_.odometry_path) {
    auto samples = load_tum(*folder_.odometry_path);
    if (!samples) return tl::unexpected(samples.error());
    placer_.odometry() = OdometryBuffer(std::move(*samples));
  }
  pending_.reserve(max_pixels(), max_columns(), kMaxPoses);
  return {};
}

void MissionReader::open_bag(ros2::RosbagMission bag) {
  bag_ = std::make_unique<ros2::RosbagMission>(std::move(bag));
  placer_ = ScanPlacer(config_.scan, bag_->T_body_cloud());
  placer_.odometry() = OdometryBuffer(bag_->take_odometry());
  pending_.reserve(max_pixels(), max_columns(), kMaxPoses);
}

bool MissionReader::has_odometry() const {
  return bag_ ? bag_->has_odometry() : folder_.odometry_path.has_value();
}

bool MissionReader::has_graph() const {
  return bag_ ? bag_->has_path() : next_graph_ < folder_.graphs.size();
}

bool MissionReader::graph_is_due() const {
  if (!has_pending_) return true;
  return bag_ ? bag_->path_is_due() : folder_.graphs[next_graph_].stamp <= pending_.stamp;
}

std::size_t MissionReader::max_pixels() const {
  return metadata_ ? geometry_.direction_L.size()
                   : static_cast<std::size_t>(config_.scan.max_points);
}

std::size_t MissionReader::max_columns() const {
  if (bag_) return ros2::PointCloudDecoder::kMaxColumns;
  return static_cast<std::size_t>(geometry_.num_columns);
}

Result<MissionReader::Item> MissionReader::next(Scan& scan) {
  while (true) {
    if (!has_pending_) {
      auto found = read_scan();
      if (!found) return tl::unexpected(found.error());
      has_pending_ = *found;
    }
    bool takes_graph = has_graph() && graph_is_due();
    if (!takes_graph && !has_pending_) return Item::kEnd;
    if (!takes_graph && placer_.place(pending_) != ScanPlacer::Placement::kPlaced) {
      // A cloud without odometry waits for the snapshot that brings its node.
      takes_graph = !has_odometry() && has_graph();
      if (!takes_graph) {
        has_pending_ = false;
        ++num_scans_unplaced_;
        ++drops_["scan_without_pose"];
        continue;
      }
    }
    if (takes_graph) {
      auto found = read_graph();
      if (!found) return tl::unexpected(found.error());
      if (*found) return Item::kGraph;
      continue;
    }
    std::swap(scan, pending_);
    has_pending_ = false;
    return Item::kScan;
  }
}

Result<bool> MissionReader::read_scan() {
  auto found = bag_                                          ? read_bag()
               : folder_.variant == MissionVariant::kPackets ? read_packets()
                                                             : read_cloud();
  if (!found || !*found) return found;
  pending_.index = static_cast<std::uint64_t>(num_scans_read_++);
  const Duration offset = Duration::from_seconds(config_.scan.stamp_offset_s);
  pending_.stamp = pending_.stamp + offset;
  pending_.last_packet = pending_.last_packet + offset;
  for (SensorTime& stamp : pending_.column_stamps) stamp = stamp + offset;
  return true;
}

Result<bool> MissionReader::read_packets() {
  UdpDatagram datagram;
  while (!assembler_->take(pending_)) {
    if (packets_ended_) return false;
    auto more = packets_->next(datagram);
    if (!more) return tl::unexpected(more.error());
    if (*more) {
      assembler_->push(datagram);
    } else {
      packets_ended_ = true;
      assembler_->flush();
    }
  }
  pending_.geometry = &geometry_;
  num_returns_read_ += num_returns(pending_);
  return true;
}

Result<bool> MissionReader::read_cloud() {
  if (next_cloud_ == folder_.clouds.size()) return false;
  const CloudFile& file = folder_.clouds[next_cloud_++];
  pending_.kind = Scan::Kind::kCloud;
  pending_.stamp = pending_.last_packet = file.stamp;
  pending_.points_L.clear();
  auto stats = load_pcd(file.path, pending_.points_L);
  if (!stats) return tl::unexpected(stats.error());
  num_returns_read_ += stats->points;
  if (stats->not_finite > 0) drops_["points_not_finite"] += stats->not_finite;
  return true;
}

Result<bool> MissionReader::read_bag() {
  auto found = bag_->next_cloud(pending_);
  if (!found || !*found) return found;
  num_returns_read_ += num_returns(pending_);
  return true;
}

Result<std::optional<PoseGraph>> MissionReader::read_graph_file() {
  const GraphFile& file = folder_.graphs[next_graph_++];
  G2oStats stats;
  auto graph = load_graph(folder_, file, {config_.fusion.default_information}, &stats);
  if (!graph) return tl::unexpected(graph.error());
  skipped_records_ += stats.skipped_records;
  drops_["graph_edges_without_information"] += stats.edges_without_information;
  if (file.stamp == kBeforeMission && has_pending_) graph->stamp = pending_.stamp;
  return std::optional(std::move(*graph));
}

Result<bool> MissionReader::read_graph() {
  auto graph = bag_ ? bag_->next_path() : read_graph_file();
  if (!graph) return tl::unexpected(graph.error());
  if (!*graph) return false;
  graph_ = std::make_unique<GraphRevision>();
  graph_->revision = ++num_revisions_;
  graph_->graph = std::move(**graph);
  placer_.complete(*graph_);
  return true;
}

std::int64_t MissionReader::num_scans_expected() const {
  if (bag_) return bag_->num_clouds();
  if (!metadata_) return static_cast<std::int64_t>(folder_.clouds.size());
  std::error_code error;
  const auto capture_bytes = std::filesystem::file_size(folder_.packets_path, error);
  if (error) return 0;
  // A packet, and what Ethernet, IP and the capture's records add to each of its fragments.
  constexpr std::size_t kFragmentBytes = 1480;
  constexpr std::size_t kOverheadBytes = 14 + 20 + 16;
  const auto packet_bytes = static_cast<std::size_t>(
      packet_layout(metadata_->profile)
          .packet_bytes(metadata_->num_beams, metadata_->columns_per_packet));
  const std::size_t scan_bytes =
      static_cast<std::size_t>(metadata_->num_columns / metadata_->columns_per_packet) *
      (packet_bytes + (packet_bytes / kFragmentBytes + 1) * kOverheadBytes);
  return static_cast<std::int64_t>(capture_bytes / scan_bytes);
}

std::map<std::string, std::int64_t> MissionReader::drops() const {
  std::map<std::string, std::int64_t> drops = drops_;
  const auto add = [&](const std::map<std::string, std::uint64_t>& counts) {
    for (const auto& [cause, count] : counts) drops[cause] += static_cast<std::int64_t>(count);
  };
  if (bag_) add(bag_->counters().drops());
  if (packets_) add(packets_->counters().drops());
  if (assembler_) add(assembler_->counters().drops());
  if (skipped_records_ > 0) drops["graph_records_skipped"] = skipped_records_;
  std::erase_if(drops, [](const auto& item) { return item.second == 0; });
  return drops;
}

std::vector<std::string> MissionReader::warnings() const {
  std::vector<std::string> warnings = folder_.warnings;
  if (bag_) warnings = bag_->warnings();
  if (packets_ && packets_->warning()) warnings.push_back(*packets_->warning());
  return warnings;
}

}  // namespace cloister
