#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/pose.hpp"
#include "mapping/core/time.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/scan/spherical_projection.hpp"

namespace cloister {

/// Where each pixel of an organised scan looks, in the sensor frame L. Computed once from the sensor's metadata.
///
/// Pixel (beam, column) of a scan is stored at `beam * num_columns + column` (row-major, rows are beams from the
/// top down, columns in the order they are fired, *staggered*: pixels of one column are measured at one instant).
/// A return of range r lies at `origin + r * direction`; see `ouster_geometry` in firmware_interface for the formula.
struct ScanGeometry {
  int num_beams = 0;
  int num_columns = 0;
  std::vector<Eigen::Vector3f> direction_L;  ///< [num_beams x num_columns], unit length
  std::vector<Eigen::Vector3f>
      origin_L;  ///< [num_beams x num_columns], where the beam's range is zero, metres
  std::vector<int> pixel_shift;  ///< [num_beams], columns to shift a row so that azimuths line up
  /// The way back from a point to a pixel; without it, scans are integrated beam by beam.
  std::optional<SphericalProjection> projection;
};

/// A pose of the sensor at a stamp, relative to the scan's reference frame R (see Scan::node).
struct PoseSample {
  SensorTime stamp;
  Pose T_R_L = Pose::Identity();
};

/// One revolution of the sensor, or one point cloud, with what is needed to place it.
///
/// Slots of this type are allocated once and reused: `reserve` sizes every vector, filling never grows one past that.
struct Scan {
  enum class Kind { kOrganised, kCloud };

  Kind kind = Kind::kOrganised;
  std::uint64_t index = 0;  ///< counts the mission's scans from 0
  SensorTime stamp;         ///< of its last column; of the file's name for a cloud
  SensorTime
      last_packet;  ///< when its last packet was received, sensor clock; equals `stamp` for a cloud

  // kOrganised: as assembled from packets.
  const ScanGeometry* geometry = nullptr;  ///< owned by whoever decodes; outlives the scan
  std::vector<std::uint32_t>
      ranges_mm;  ///< [num_beams x num_columns] as ScanGeometry; 0 = no return
  std::vector<SensorTime>
      column_stamps;  ///< [num_columns]; meaningless where the column is not valid
  std::vector<std::uint8_t> column_valid;  ///< [num_columns]; 0 = never received

  // kCloud: points in the cloud's own frame L; beams start at its origin. Already deskewed.
  std::vector<Eigen::Vector3f> points_L;

  // Where it was taken: poses T_R_L sorted by stamp that cover the scan. R is the graph node `node`, or the
  // odometry frame while no graph is known (node == kNoNode).
  NodeId node = kNoNode;
  std::vector<PoseSample> poses;
  std::optional<Pose>
      T_O_L;  ///< odometry at `stamp`, where there is odometry: tells a correction from motion

  /// Sizes the vectors for scans of up to `max_pixels` pixels or points, `max_columns` columns, `max_poses` samples.
  void reserve(std::size_t max_pixels, std::size_t max_columns, std::size_t max_poses) {
    ranges_mm.reserve(max_pixels);
    points_L.reserve(max_pixels);
    column_stamps.reserve(max_columns);
    column_valid.reserve(max_columns);
    poses.reserve(max_poses);
  }
};

}  // namespace cloister
