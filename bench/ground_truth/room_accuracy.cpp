#include "bench/ground_truth/room_accuracy.hpp"

#include <map>

namespace cloister {

double adjusted_rand_index(const std::vector<std::pair<std::int64_t, std::int64_t>>& labels) {
  std::map<std::pair<std::int64_t, std::int64_t>, double> both;
  std::map<std::int64_t, double> first;
  std::map<std::int64_t, double> second;
  for (const auto& label : labels) {
    both[label] += 1.0;
    first[label.first] += 1.0;
    second[label.second] += 1.0;
  }
  const auto pairs = [](double n) { return 0.5 * n * (n - 1.0); };
  const auto sum_pairs = [&](const auto& counts) {
    double sum = 0.0;
    for (const auto& entry : counts) sum += pairs(entry.second);
    return sum;
  };
  const double all = pairs(static_cast<double>(labels.size()));
  if (!(all > 0.0)) return 1.0;
  const double expected = sum_pairs(first) * sum_pairs(second) / all;
  const double best = 0.5 * (sum_pairs(first) + sum_pairs(second));
  return best > expected ? (sum_pairs(both) - expected) / (best - expected) : 1.0;
}

RoomAccuracy compare_rooms(const GroundTruth& truth, const std::vector<SubmapScans>& submaps,
                           double margin_m) {
  RoomAccuracy result;
  result.final_submaps = submaps.size();
  std::vector<std::map<std::int64_t, std::size_t>> scans_by_submap(truth.rooms.size());
  std::vector<std::pair<std::int64_t, std::int64_t>> labels;
  for (const SubmapScans& submap : submaps) {
    for (const SensorTime stamp : submap.stamps) {
      const Eigen::Vector3d p_W = pose_at(truth.T_W_L, stamp).translation();
      for (std::size_t k = 0; k < truth.rooms.size(); ++k) {
        if (!truth.rooms[k].contains(p_W, margin_m)) continue;
        ++scans_by_submap[k][submap.id];
        labels.emplace_back(static_cast<std::int64_t>(k), submap.id);
        break;
      }
    }
  }
  for (std::size_t k = 0; k < truth.rooms.size(); ++k) {
    RoomShare share{truth.rooms[k], 0, 0};
    for (const auto& entry : scans_by_submap[k]) share.scans += entry.second;
    for (const auto& entry : scans_by_submap[k])
      share.submaps += 10 * entry.second >= share.scans ? 1 : 0;
    result.rooms.push_back(std::move(share));
  }
  result.scans = labels.size();
  result.adjusted_rand_index = adjusted_rand_index(labels);
  return result;
}

}  // namespace cloister
