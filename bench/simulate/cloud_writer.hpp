#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "bench/simulate/scan_simulator.hpp"
#include "bench/simulate/trajectory.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// How a mission without packets hands its scans over: one cloud a graph node, in the sensor's frame at that node.
enum class CloudKind {
  kScans,    ///< all that was seen within a revolution before the node, or since the node before if that is less
  kGathered  ///< every fourth beam and column since the node before: a lidar of 16 beams on a robot that walks
};

/// As on the command line: scans, gathered.
[[nodiscard]] const std::map<std::string, CloudKind>& cloud_kind_names();

/// Cuts simulated scans into clouds and writes each as cloud_<sec>_<nsec>.pcd. The sensor's motion within a cloud is taken
/// out by odometry, as a SLAM system does it, with its error.
class CloudWriter {
 public:
  /// The points of one revolution, column by column.
  struct Revolution {
    struct Column {
      SensorTime stamp;
      std::size_t end = 0;  ///< of its points
    };
    std::vector<Column> columns;
    std::vector<Eigen::Vector3d> points_O;
  };

  /// All that is given must outlive the writer.
  /// @param truth T_W_L @param odometry T_O_L, same stamps @param node_stamps ascending
  /// @param start when the first scan begins
  CloudWriter(const ScanSimulator& simulator, CloudKind kind, const Trajectory& truth, const Trajectory& odometry,
              std::span<const SensorTime> node_stamps, SensorTime start, std::filesystem::path folder);

  /// Simulates one revolution. Threads: const, several at once.
  void record(std::uint64_t scan, Revolution* out) const;
  /// Takes revolutions in their order, and writes the clouds of the nodes before their last columns; a node before the first
  /// scan gets none. Errors: kResource when the disk refuses
  [[nodiscard]] Result<void> take(const Revolution& revolution);
  [[nodiscard]] std::size_t num_written() const { return num_written_; }

 private:
  struct Piece {
    SensorTime stamp;
    std::vector<Eigen::Vector3d> points_O;
  };

  [[nodiscard]] Result<void> write_cloud(SensorTime node_stamp);

  const ScanSimulator& simulator_;
  const Trajectory& truth_;
  const Trajectory& odometry_;
  const std::span<const SensorTime> node_stamps_;
  const SensorTime start_;
  const std::filesystem::path folder_;
  const CloudKind kind_;
  const BeamFan fan_;
  std::size_t next_node_ = 0;
  std::size_t num_written_ = 0;
  std::deque<Piece> pieces_;  ///< columns of the next cloud, oldest first
};

}  // namespace cloister
