#include "bench/experiments/rounds.hpp"

#include <limits>
#include <set>

namespace cloister {

namespace {

/// The room that holds a place, or -1.
int room_at(const std::vector<Room>& rooms, const Eigen::Vector3d& p_W, double margin_m) {
  for (std::size_t k = 0; k < rooms.size(); ++k) {
    if (rooms[k].contains(p_W, margin_m)) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace

std::vector<SensorTime> round_ends(const GroundTruth& truth) {
  std::vector<SensorTime> ends;
  if (truth.rooms.empty()) return ends;
  const Eigen::Vector3d middle_W = 0.5 * (truth.rooms[0].min_W + truth.rooms[0].max_W);
  std::set<int> others;
  SensorTime nearest;
  double nearest_m = std::numeric_limits<double>::infinity();
  const auto finish_round = [&] {
    if (nearest_m == std::numeric_limits<double>::infinity()) return;
    ends.push_back(nearest);
    nearest_m = std::numeric_limits<double>::infinity();
    others.clear();
  };
  for (const StampedPose& pose : truth.T_W_L) {
    const Eigen::Vector3d p_W = pose.pose.translation();
    const int room = room_at(truth.rooms, p_W, 0.0);
    if (room > 0) {
      finish_round();
      others.insert(room);
    }
    if (room != 0 || others.size() + 1 < truth.rooms.size()) continue;
    const double distance_m = (p_W - middle_W).head<2>().norm();
    if (distance_m < nearest_m) {
      nearest_m = distance_m;
      nearest = pose.stamp;
    }
  }
  finish_round();
  return ends;
}

std::size_t submaps_across_storeys(const GroundTruth& truth,
                                   const std::vector<SubmapScans>& submaps, double margin_m) {
  std::size_t across = 0;
  for (const SubmapScans& submap : submaps) {
    std::set<int> storeys;
    for (const SensorTime stamp : submap.stamps) {
      const int room = room_at(truth.rooms, pose_at(truth.T_W_L, stamp).translation(), margin_m);
      if (room < 0) continue;
      const Room& held = truth.rooms[static_cast<std::size_t>(room)];
      if (!held.name.ends_with("stairwell")) storeys.insert(held.storey);
    }
    across += storeys.size() > 1 ? 1 : 0;
  }
  return across;
}

}  // namespace cloister
