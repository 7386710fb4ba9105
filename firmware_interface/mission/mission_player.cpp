#include "firmware_interface/mission/mission_player.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/files/tum_file.hpp"
#include "firmware_interface/mission/scan_placer.hpp"
#include "firmware_interface/ouster/ouster_geometry.hpp"

namespace cloister {
namespace {

constexpr SensorTime kNever{std::numeric_limits<std::int64_t>::max()};

}  // namespace

Result<std::unique_ptr<MissionPlayer>> MissionPlayer::open(const std::filesystem::path& path,
                                                           Lidar lidar) {
  auto folder = open_mission(path);
  if (!folder) return tl::unexpected(folder.error());
  if (folder->variant != MissionVariant::kPackets) {
    return fail(
        ErrorKind::kInput,
        path.string() + ": holds clouds, which no sensor sends; play a mission with lidar.pcap");
  }
  std::unique_ptr<MissionPlayer> player(new MissionPlayer(std::move(*folder), lidar));
  if (auto opened = player->open_files(); !opened) return tl::unexpected(opened.error());
  return player;
}

Result<void> MissionPlayer::open_files() {
  auto json = read_file(folder_.metadata_path);
  if (!json) return tl::unexpected(json.error());
  metadata_json_ = std::move(*json);
  auto metadata = parse_metadata(metadata_json_, folder_.metadata_path.string());
  if (!metadata) return tl::unexpected(metadata.error());
  metadata_ = std::move(*metadata);
  geometry_ = make_geometry(*metadata_);
  auto source = PcapSource::open(folder_.packets_path);
  if (!source) return tl::unexpected(source.error());
  source_.emplace(std::move(*source));
  assembler_.emplace(*metadata_);
  decoder_.emplace(metadata_->profile, metadata_->num_beams, metadata_->columns_per_packet);
  auto odometry = load_tum(*folder_.odometry_path);
  if (!odometry) return tl::unexpected(odometry.error());
  odometry_ = std::move(*odometry);
  due_ = {std::numeric_limits<std::int64_t>::min()};
  return find_lidar_item();
}

Pose MissionPlayer::T_pose_sensor() const {
  if (folder_.T_pose_sensor) return *folder_.T_pose_sensor;
  return folder_.pose_frame == PoseFrame::kLidar ? metadata_->T_sensor_lidar.inverse()
                                                 : Pose::Identity();
}

std::uint64_t MissionPlayer::session() const {
  return odometry_.empty() ? 1 : static_cast<std::uint64_t>(odometry_.front().stamp.ns);
}

Result<void> MissionPlayer::find_lidar_item() {
  has_lidar_item_ = true;
  while (true) {
    if (lidar_ == Lidar::kScans && assembler_->take(next_scan_)) {
      next_scan_.geometry = &geometry_;
      lidar_due_ = std::max(next_scan_.stamp, next_scan_.last_packet);
      return {};
    }
    if (is_source_ended_) {
      has_lidar_item_ = false;
      return {};
    }
    UdpDatagram datagram;
    auto more = source_->next(datagram);
    if (!more) return tl::unexpected(more.error());
    if (!*more) {
      is_source_ended_ = true;
      assembler_->flush();
    } else if (lidar_ == Lidar::kScans) {
      assembler_->push(datagram);
    } else if (datagram.destination_port == metadata_->lidar_port) {
      next_packet_.assign(datagram.payload.begin(), datagram.payload.end());
      // What is no packet of this sensor goes right behind the one before it.
      if (next_packet_.size() == decoder_->packet_bytes()) {
        const ColumnHeader last =
            decoder_->column(next_packet_, decoder_->columns_per_packet() - 1);
        if (last.valid) lidar_due_ = last.stamp;
      }
      return {};
    }
  }
}

Result<MissionPlayer::Item> MissionPlayer::next() {
  const SensorTime lidar_due = has_lidar_item_ ? lidar_due_ : kNever;
  const SensorTime odometry_due =
      next_odometry_ < odometry_.size() ? odometry_[next_odometry_].stamp : kNever;
  const SensorTime graph_due =
      next_graph_ < folder_.graphs.size() ? folder_.graphs[next_graph_].stamp : kNever;
  const SensorTime earliest = std::min({lidar_due, odometry_due, graph_due});
  if (earliest == kNever) return Item::kEnd;
  due_ = std::max(due_, earliest);

  if (graph_due == earliest) {
    const GraphFile& file = folder_.graphs[next_graph_++];
    // Edges without information keep that mark: what stands in for it is for the mapper to decide.
    auto graph = load_graph(folder_, file, {1.0});
    if (!graph) return tl::unexpected(graph.error());
    graph_ = {session(), next_graph_, 0, std::move(*graph)};
    graph_.graph.stamp = earliest;
    return Item::kGraph;
  }
  if (odometry_due == earliest) {
    ++next_odometry_;
    return Item::kOdometry;
  }
  std::swap(scan_, next_scan_);
  std::swap(packet_, next_packet_);
  if (auto found = find_lidar_item(); !found) return tl::unexpected(found.error());
  return lidar_ == Lidar::kScans ? Item::kScan : Item::kPacket;
}

}  // namespace cloister
