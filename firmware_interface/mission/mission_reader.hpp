#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/files/mission_folder.hpp"
#include "firmware_interface/mission/scan_placer.hpp"
#include "firmware_interface/ouster/pcap_source.hpp"
#include "firmware_interface/ouster/scan_assembler.hpp"
#include "mapping/core/config.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

namespace ros2 {
class RosbagMission;
}

/// A recorded mission as the sequence a robot would have seen: scans with their poses, and graph
/// snapshots between them, each before the first scan that is not older than it.
///
/// A mission is a directory as MissionFolder has it, or a recording of rosbag2 (see RosbagMission).
///
/// Scans are placed as ScanPlacer says. A cloud without odometry waits for the snapshot that brings
/// its node.
///
/// Threads: one at a time. Allocates.
class MissionReader {
 public:
  enum class Item { kScan, kGraph, kEnd };

  ~MissionReader();

  /// Opens the mission and reads metadata and odometry. Fails with kInput, naming file and line.
  [[nodiscard]] static Result<std::unique_ptr<MissionReader>> open(
      const std::filesystem::path& path, const Config& config);

  /// Reads on. A scan is put into `scan`, which should be reserved for `max_pixels()`,
  /// `max_columns()` and `kMaxPoses`; a graph is to be fetched with `take_graph`. Scans without a
  /// pose are counted and passed over. Fails with kInput, naming the file that cannot be read on.
  [[nodiscard]] Result<Item> next(Scan& scan);
  [[nodiscard]] std::unique_ptr<GraphRevision> take_graph() { return std::move(graph_); }

  [[nodiscard]] std::size_t max_pixels() const;
  [[nodiscard]] std::size_t max_columns() const;
  static constexpr std::size_t kMaxPoses = ScanPlacer::kMaxPoses;

  [[nodiscard]] const std::string& name() const;
  /// Scans assembled or clouds read so far, placed or not.
  [[nodiscard]] std::int64_t num_scans_read() const { return num_scans_read_; }
  /// How many scans the mission holds, roughly: from the capture's size, or the number of clouds.
  [[nodiscard]] std::int64_t num_scans_expected() const;
  /// Scans that were read but could not be placed.
  [[nodiscard]] std::int64_t num_scans_unplaced() const { return num_scans_unplaced_; }
  /// Returns in the scans read so far, whatever their range.
  [[nodiscard]] std::int64_t num_returns_read() const { return num_returns_read_; }
  /// Everything lost so far, by cause.
  [[nodiscard]] std::map<std::string, std::int64_t> drops() const;
  /// One line for everything that is odd, but can be lived with.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  MissionReader(MissionFolder folder, const Config& config);

  [[nodiscard]] Result<void> open_files();
  void open_bag(ros2::RosbagMission bag);
  [[nodiscard]] Result<bool> read_scan();
  [[nodiscard]] Result<bool> read_packets();
  [[nodiscard]] Result<bool> read_cloud();
  [[nodiscard]] Result<bool> read_bag();
  [[nodiscard]] bool has_odometry() const;
  [[nodiscard]] bool has_graph() const;
  [[nodiscard]] bool graph_is_due() const;
  /// @return false when it was counted and passed over
  [[nodiscard]] Result<bool> read_graph();
  [[nodiscard]] Result<std::optional<PoseGraph>> read_graph_file();

  MissionFolder folder_;
  Config config_;
  std::unique_ptr<ros2::RosbagMission> bag_;  ///< in place of the folder
  std::optional<SensorMetadata> metadata_;
  ScanGeometry geometry_;
  std::optional<PcapSource> packets_;
  std::optional<ScanAssembler> assembler_;
  bool packets_ended_ = false;
  std::size_t next_cloud_ = 0;
  ScanPlacer placer_;
  std::size_t next_graph_ = 0;
  std::unique_ptr<GraphRevision> graph_;
  std::uint64_t num_revisions_ = 0;

  Scan pending_;
  bool has_pending_ = false;
  std::int64_t num_scans_read_ = 0;
  std::int64_t num_scans_unplaced_ = 0;
  std::int64_t num_returns_read_ = 0;
  std::map<std::string, std::int64_t> drops_;
  std::int64_t skipped_records_ = 0;
};

}  // namespace cloister
