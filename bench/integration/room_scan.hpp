#pragma once

#include <memory>

#include <Eigen/Core>

#include "mapping/scan/scan.hpp"

namespace cloister {

/// A scan of an empty rectangular room, computed, not measured: the same on every machine. The room is turned by some
/// degrees, since walls along the voxel grid are easier than others.
struct RoomScan {
  std::unique_ptr<ScanGeometry> geometry;  ///< what `scan` points to
  Scan scan;  ///< of 64 x 1024 pixels over +-45 degrees; R is S, the sensor at its origin
};

/// @param size_m  length, width and height of the room; the sensor stands in its middle, 1.2 m above the floor
[[nodiscard]] RoomScan make_room_scan(const Eigen::Vector3d& size_m);

}  // namespace cloister
