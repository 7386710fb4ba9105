#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "firmware_interface/ros2/beam_table_fit.hpp"
#include "firmware_interface/ros2/message_counters.hpp"
#include "firmware_interface/ros2/ros2_types.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister::ros2 {

/// Turns the clouds that a LiDAR driver publishes into scans, in the cloud's own frame (`header.frame_id`).
///
/// Fields are found by name and type: x, y, z (FLOAT32 or FLOAT64, metres); t (UINT32, nanoseconds since the header's
/// stamp); ring (UINT8 or UINT16); range (UINT32). A point at the origin, one that is not finite, and one whose range
/// is zero is a miss.
///
/// A cloud of height > 1 becomes an organised scan once the sensor's beams are known, which they are after the first
/// cloud or a few (see BeamTableFit): its rows are beams from the top down, its columns cover one turn, and `t` says
/// which pixels were measured at one instant, so that it does not matter whether the driver lined azimuths up. Columns
/// are counted from the one that is fired first, found in a cloud without a lost packet. Every other cloud becomes
/// Scan::Kind::kCloud, its points as they are at the header's stamp: unorganised ones, deskewed ones, those of other
/// sensors, and each that is not as the beam table has it.
///
/// A row that nothing has been seen by is filled in from its neighbours, and its returns are left out and counted
/// until enough of them have come. The table is then made anew, at most `kMaxTables` times.
///
/// Threads: one at a time; `geometry` of the scans belongs to the decoder. Memory: a few tables of 24 bytes a pixel,
/// and the points of one cloud.
class PointCloudDecoder {
 public:
  static constexpr std::size_t kMaxTables = 8;
  /// Images with more columns are taken as points.
  static constexpr int kMaxColumns = 4096;

  /// @param max_points   larger clouds are counted and dropped
  /// @param clouds_only  makes every cloud Scan::Kind::kCloud
  explicit PointCloudDecoder(std::size_t max_points, bool clouds_only = false)
      : max_points_(max_points), clouds_only_(clouds_only) {}

  /// Fills kind, stamps, geometry, and ranges or points; `index`, `node` and `poses` are the caller's.
  /// Does not allocate for an organised scan, once the beams are known and when `scan` is reserved.
  /// @return false, counted, when the message is no cloud; `scan` is then undefined
  [[nodiscard]] bool scan(const PointCloud2& message, MessageCounters& counters, Scan& scan);

  /// Name of L; empty before the first cloud. Clouds in another frame are counted and dropped.
  [[nodiscard]] const std::string& frame() const { return frame_; }
  /// The newest beam table, or null.
  [[nodiscard]] const ScanGeometry* geometry() const {
    return tables_.empty() ? nullptr : tables_.back().get();
  }

 private:
  [[nodiscard]] std::optional<MessageCause> read(const PointCloud2& message);
  void learn();
  bool find_first_columns();
  [[nodiscard]] bool rows_are_beams() const;
  [[nodiscard]] bool fill_organised(SensorTime stamp, MessageCounters& counters, Scan& scan) const;

  std::size_t max_points_;
  bool clouds_only_;
  bool has_begun_ = false;
  std::string frame_;

  // The cloud at hand, as an image.
  int num_rows_ = 0;
  int num_columns_ = 0;
  std::vector<Eigen::Vector3f> points_L_;  ///< [rows x columns]; NaN is a miss
  std::vector<std::uint32_t> offset_ns_;   ///< [rows x columns] since the header's stamp, or empty
  std::vector<std::uint16_t> ring_;        ///< [rows x columns], or empty

  // The sensor.
  int table_rows_ = 0;
  int table_columns_ = 0;
  std::optional<BeamTableFit> fit_;
  int num_clouds_in_fit_ = 0;
  std::vector<int> first_column_;  ///< [rows] column of the image that is fired first; or empty
  std::vector<std::unique_ptr<const ScanGeometry>> tables_;  ///< scans under way may use older ones
  std::vector<char> row_is_known_;                           ///< [rows] of the newest table
};

}  // namespace cloister::ros2
