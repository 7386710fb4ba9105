#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_interface/files/mission_folder.hpp"
#include "firmware_interface/files/stamped_pose.hpp"
#include "firmware_interface/mission/graph_keeper.hpp"
#include "firmware_interface/ouster/packet_decoder.hpp"
#include "firmware_interface/ouster/pcap_source.hpp"
#include "firmware_interface/ouster/scan_assembler.hpp"
#include "mapping/core/result.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// A recorded mission of packets as the stream of what the robot sent, each item with the stamp at which it was there:
/// odometry at its own, graphs when they were published, scans with their last packet, packets with their last column.
///
/// Threads: one at a time. Allocates.
class MissionPlayer {
 public:
  enum class Item { kOdometry, kGraph, kScan, kPacket, kEnd };
  enum class Lidar { kScans, kPackets };

  /// Opens the folder, reads metadata and odometry, and finds the first item of the lidar.
  /// @param lidar  whether packets are put together to scans, or given as they are
  /// @return kInput, naming the file; also for a mission of clouds, which no sensor has sent
  [[nodiscard]] static Result<std::unique_ptr<MissionPlayer>> open(
      const std::filesystem::path& path, Lidar lidar);

  /// Goes on to the next item. Fails with kInput, naming the file that cannot be read on.
  [[nodiscard]] Result<Item> next();
  /// When the item was there, by the sensor's clock. Never goes back.
  [[nodiscard]] SensorTime due() const { return due_; }

  // The item at hand, valid until the next call of `next`.
  [[nodiscard]] const StampedPose& odometry() const { return odometry_[next_odometry_ - 1]; }
  [[nodiscard]] const GraphUpdate& graph() const { return graph_; }
  [[nodiscard]] const Scan& scan() const { return scan_; }
  [[nodiscard]] std::span<const std::byte> packet() const { return packet_; }

  [[nodiscard]] const SensorMetadata& metadata() const { return *metadata_; }
  [[nodiscard]] const std::string& metadata_json() const { return metadata_json_; }
  /// Pose of the sensor in the frame whose poses odometry and graph hold.
  [[nodiscard]] Pose T_pose_sensor() const;
  /// The same for every playing of one mission, so that a mapper sees one odometry and one SLAM system.
  [[nodiscard]] std::uint64_t session() const;

 private:
  MissionPlayer(MissionFolder folder, Lidar lidar) : folder_(std::move(folder)), lidar_(lidar) {}

  [[nodiscard]] Result<void> open_files();
  [[nodiscard]] Result<void> find_lidar_item();

  MissionFolder folder_;
  Lidar lidar_;
  std::string metadata_json_;
  std::optional<SensorMetadata> metadata_;
  ScanGeometry geometry_;
  std::optional<PcapSource> source_;
  std::optional<ScanAssembler> assembler_;
  std::optional<PacketDecoder> decoder_;
  std::vector<StampedPose> odometry_;
  std::size_t next_odometry_ = 0;
  std::size_t next_graph_ = 0;

  // The lidar's next item, found ahead of its turn.
  bool has_lidar_item_ = false;
  bool is_source_ended_ = false;
  SensorTime lidar_due_;
  Scan next_scan_;
  std::vector<std::byte> next_packet_;

  SensorTime due_;
  Scan scan_;
  std::vector<std::byte> packet_;
  GraphUpdate graph_;
};

}  // namespace cloister
