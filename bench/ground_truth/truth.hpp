#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "bench/simulate/trajectory.hpp"
#include "bench/simulate/triangle_mesh.hpp"
#include "bench/simulate/world.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// What a simulated mission knows about itself: MISSION/ground_truth/.
struct GroundTruth {
  std::vector<StampedPose> T_W_L;  ///< the sensor's true poses, rising stamps
  TriangleMesh mesh_W;
  std::vector<Room> rooms;  ///< empty for a world without rooms
};

/// Reads trajectory.tum, mesh.ply and rooms.json. Errors: kInput with file and place
[[nodiscard]] Result<GroundTruth> read_ground_truth(const std::filesystem::path& mission);

/// One final submap and the scans it holds.
struct SubmapScans {
  std::int64_t id = 0;
  std::vector<SensorTime> stamps;
  std::vector<std::int64_t> nodes = {};  ///< of the pose graph, ascending

  [[nodiscard]] bool holds_node(std::int64_t node) const {
    return std::binary_search(nodes.begin(), nodes.end(), node);
  }
};

/// Reads OUT/submaps.json. Errors: kInput with file and what is missing
[[nodiscard]] Result<std::vector<SubmapScans>> read_submaps(const std::filesystem::path& file);

/// Graph nodes that a loop closure joins, the older first.
using Closure = std::pair<std::int64_t, std::int64_t>;

/// Reads MISSION/ground_truth/wrong_closures.csv; a mission without the file has none. Errors: kInput with file:line
[[nodiscard]] Result<std::vector<Closure>> read_wrong_closures(const std::filesystem::path& file);

}  // namespace cloister
