#include "firmware_interface/mission/mission_reader.hpp"

#include <algorithm>
#include <cstdlib>

#include "firmware_interface/files/pcd_file.hpp"
#include "firmware_interface/files/tum_file.hpp"
#include "firmware_interface/ouster/ouster_geometry.hpp"

namespace cloister {
namespace {

// A cloud belongs to the node of its stamp; tools that write stamps as doubles miss by some 100 ns.
constexpr std::int64_t kSameStampNs = 1'000'000;

}  // namespace

Result<std::unique_ptr<MissionReader>> MissionReader::open(const std::filesystem::path& path,
                                                           const Config& config) {
  auto folder = open_mission(path);
  if (!folder) return tl::unexpected(folder.error());
  std::unique_ptr<MissionReader> reader(new MissionReader(std::move(*folder), config));
  if (auto opened = reader->open_files(); !opened) return tl::unexpected(opened.error());
  return reader;
}

Result<void> MissionReader::open_files() {
  if (folder_.variant == MissionVariant::kPackets) {
    auto metadata = load_metadata(folder_.metadata_path);
    if (!metadata) return tl::unexpected(metadata.error());
    metadata_ = std::move(*metadata);
    geometry_ = make_geometry(*metadata_);
    auto packets = PcapSource::open(folder_.packets_path);
    if (!packets) return tl::unexpected(packets.error());
    packets_.emplace(std::move(*packets));
    assembler_.emplace(*metadata_);
    if (folder_.pose_frame == PoseFrame::kLidar) T_B_L_ = metadata_->T_sensor_lidar.inverse();
  }
  if (folder_.T_pose_sensor) T_B_L_ = *folder_.T_pose_sensor;
  if (folder_.odometry_path) {
    auto samples = load_tum(*folder_.odometry_path);
    if (!samples) return tl::unexpected(samples.error());
    odometry_ = OdometryBuffer(std::move(*samples));
  }
  pending_.reserve(max_pixels(), max_columns(), kMaxPoses);
  return {};
}

std::size_t MissionReader::max_pixels() const {
  return metadata_ ? geometry_.direction_L.size()
                   : static_cast<std::size_t>(config_.scan.max_points);
}

std::size_t MissionReader::max_columns() const {
  return static_cast<std::size_t>(geometry_.num_columns);
}

Result<MissionReader::Item> MissionReader::next(Scan& scan) {
  while (true) {
    if (!has_pending_) {
      auto found = read_scan();
      if (!found) return tl::unexpected(found.error());
      has_pending_ = *found;
    }
    const bool graph_is_due =
        next_graph_ < folder_.graphs.size() &&
        (!has_pending_ || folder_.graphs[next_graph_].stamp <= pending_.stamp);
    if (graph_is_due) return read_graph();
    if (!has_pending_) return Item::kEnd;
    if (!place_by_node() && !place_by_odometry()) {
      // A cloud without odometry waits for the snapshot that brings its node.
      if (!folder_.odometry_path && next_graph_ < folder_.graphs.size()) return read_graph();
      has_pending_ = false;
      ++num_scans_unplaced_;
      ++drops_["scan_without_pose"];
      continue;
    }
    std::swap(scan, pending_);
    has_pending_ = false;
    return Item::kScan;
  }
}

Result<bool> MissionReader::read_scan() {
  auto found = folder_.variant == MissionVariant::kPackets ? read_packets() : read_cloud();
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
  num_returns_read_ += static_cast<std::int64_t>(pending_.ranges_mm.size()) -
                       std::count(pending_.ranges_mm.begin(), pending_.ranges_mm.end(), 0u);
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

Result<MissionReader::Item> MissionReader::read_graph() {
  const GraphFile& file = folder_.graphs[next_graph_++];
  G2oStats stats;
  auto graph = load_graph(folder_, file, {config_.fusion.default_information}, &stats);
  if (!graph) return tl::unexpected(graph.error());
  skipped_records_ += stats.skipped_records;
  drops_["graph_edges_without_information"] += stats.edges_without_information;

  graph_ = std::make_unique<GraphRevision>();
  graph_->revision = ++num_revisions_;
  graph_->graph = std::move(*graph);
  if (file.stamp == kBeforeMission && has_pending_) graph_->graph.stamp = pending_.stamp;
  const OdometryBuffer::Limits limits{Duration::from_seconds(config_.scan.max_odometry_gap_s),
                                      Duration::from_seconds(config_.scan.max_odometry_wait_s)};
  nodes_.clear();
  for (const GraphNode& node : graph_->graph.nodes) {
    graph_->T_O_N.push_back(odometry_.at(node.stamp, limits));
    nodes_.push_back({node.stamp, node.id, graph_->T_O_N.back()});
  }
  std::stable_sort(nodes_.begin(), nodes_.end(),
                   [](const KnownNode& a, const KnownNode& b) { return a.stamp < b.stamp; });
  for (std::size_t i = 0; i < graph_->graph.edges.size(); ++i) {
    const GraphEdge& edge = graph_->graph.edges[i];
    if (edge.is_loop_closure() && known_loops_.insert(std::minmax(edge.from, edge.to)).second) {
      graph_->new_loops.push_back(i);
    }
  }
  return Item::kGraph;
}

bool MissionReader::place_by_node() {
  if (pending_.kind != Scan::Kind::kCloud) return false;
  const auto it =
      std::lower_bound(nodes_.begin(), nodes_.end(), SensorTime{pending_.stamp.ns - kSameStampNs},
                       [](const KnownNode& node, SensorTime stamp) { return node.stamp < stamp; });
  if (it == nodes_.end() || std::abs((it->stamp - pending_.stamp).ns) > kSameStampNs) return false;
  pending_.node = it->id;
  pending_.poses.assign(1, {pending_.stamp, T_B_L_});
  pending_.T_O_L.reset();
  if (it->T_O_N) pending_.T_O_L = *it->T_O_N * T_B_L_;
  return true;
}

bool MissionReader::place_by_odometry() {
  SensorTime begin = pending_.stamp;
  if (pending_.kind == Scan::Kind::kOrganised) {
    for (std::size_t column = 0; column < pending_.column_valid.size(); ++column) {
      if (pending_.column_valid[column]) begin = std::min(begin, pending_.column_stamps[column]);
    }
  }
  const OdometryBuffer::Limits limits{Duration::from_seconds(config_.scan.max_odometry_gap_s),
                                      Duration::from_seconds(config_.scan.max_odometry_wait_s)};
  if (odometry_.cover(begin, pending_.stamp, limits, kMaxPoses, pending_.poses) !=
      OdometryBuffer::Coverage::kCovered) {
    return false;
  }
  auto newest =
      std::upper_bound(nodes_.begin(), nodes_.end(), pending_.stamp,
                       [](SensorTime stamp, const KnownNode& node) { return stamp < node.stamp; });
  while (newest != nodes_.begin() && !std::prev(newest)->T_O_N) --newest;
  Pose T_R_O = Pose::Identity();
  pending_.node = kNoNode;
  if (newest == nodes_.begin()) {
    // All nodes with odometry are younger: the first of them is as good a reference.
    newest = std::find_if(nodes_.begin(), nodes_.end(),
                          [](const KnownNode& node) { return node.T_O_N.has_value(); });
  } else {
    --newest;
  }
  if (newest != nodes_.end()) {
    pending_.node = newest->id;
    T_R_O = newest->T_O_N->inverse();
  }
  pending_.T_O_L = pending_.poses.back().T_R_L * T_B_L_;
  for (PoseSample& sample : pending_.poses) sample.T_R_L = T_R_O * sample.T_R_L * T_B_L_;
  return true;
}

std::int64_t MissionReader::num_scans_expected() const {
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
  if (packets_) add(packets_->counters().drops());
  if (assembler_) add(assembler_->counters().drops());
  if (skipped_records_ > 0) drops["graph_records_skipped"] = skipped_records_;
  std::erase_if(drops, [](const auto& item) { return item.second == 0; });
  return drops;
}

std::vector<std::string> MissionReader::warnings() const {
  std::vector<std::string> warnings = folder_.warnings;
  if (packets_ && packets_->warning()) warnings.push_back(*packets_->warning());
  return warnings;
}

}  // namespace cloister
