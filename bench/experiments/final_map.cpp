#include "bench/experiments/final_map.hpp"

#include <algorithm>
#include <bit>
#include <fstream>

#include "bench/integration/placed_scan.hpp"
#include "firmware_interface/files/tum_file.hpp"
#include "firmware_interface/map/map_file.hpp"
#include "firmware_interface/mission/mission_reader.hpp"
#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {

static_assert(std::endian::native == std::endian::little, "returns are written as they lie");

Result<std::vector<RemainingPair>> find_remaining_pairs(const std::filesystem::path& map,
                                                        double min_overlap) {
  const auto loaded = load_map(map);
  if (!loaded) return tl::unexpected(loaded.error());
  const double voxel_size_m = loaded->info.voxel_size_m;
  std::vector<Eigen::AlignedBox3d> boxes_M;
  for (const Submap& submap : loaded->submaps) {
    const auto box_S = known_bounds(*loaded->store, submap.volume, voxel_size_m);
    boxes_M.push_back(box_S.isEmpty() ? box_S : box_S.transformed(submap.T_M_S));
  }
  std::vector<RemainingPair> pairs;
  for (std::size_t i = 0; i < loaded->submaps.size(); ++i) {
    for (std::size_t j = i + 1; j < loaded->submaps.size(); ++j) {
      const Submap& a = loaded->submaps[i];
      const Submap& b = loaded->submaps[j];
      if (!boxes_M[i].intersects(boxes_M[j])) continue;
      const VoxelOverlap overlap = voxel_overlap(*loaded->store, a.volume, b.volume,
                                                 b.T_M_S.inverse() * a.T_M_S, voxel_size_m);
      const double ratio = std::max(overlap.ratio_a(), overlap.ratio_b());
      if (ratio > min_overlap) pairs.push_back({a.id, b.id, a.root, b.root, ratio});
    }
  }
  return pairs;
}

Result<std::size_t> write_placed_returns(const std::filesystem::path& mission,
                                         const std::filesystem::path& trajectory,
                                         const ReturnSampling& sampling,
                                         const std::filesystem::path& file) {
  const auto T_M_L = load_tum(trajectory);
  if (!T_M_L) return tl::unexpected(T_M_L.error());
  const Config config;
  auto reader = MissionReader::open(mission, config);
  if (!reader) return tl::unexpected(reader.error());
  std::ofstream stream(file, std::ios::binary);
  std::size_t returns = 0;
  std::size_t scans = 0;
  PlacedScan placed;
  while (true) {
    const auto item = (*reader)->next(placed.scan);
    if (!item) return tl::unexpected(item.error());
    if (*item == MissionReader::Item::kEnd) break;
    if (*item == MissionReader::Item::kGraph) {
      static_cast<void>((*reader)->take_graph());
      continue;
    }
    if (scans++ % static_cast<std::size_t>(sampling.every_scan) != 0) continue;
    const SensorTime stamp = placed.scan.stamp;
    const auto pose =
        std::lower_bound(T_M_L->begin(), T_M_L->end(), stamp,
                         [](const StampedPose& sample, SensorTime t) { return sample.stamp < t; });
    if (pose == T_M_L->end() || pose->stamp != stamp) continue;
    placed.T_S_R = Pose::Identity();
    placed.T_S_R = pose->T_O_B * sensor_pose(placed, stamp).inverse();  // S is M here
    for (const Beam& beam : place_beams(placed, config.voxel, sampling.every_pixel)) {
      stream.write(reinterpret_cast<const char*>(beam.end_S.data()), 3 * sizeof(float));
      ++returns;
    }
  }
  stream.close();
  if (!stream)
    return fail(ErrorKind::kResource, file.string() + ": cannot be written: free some space");
  return returns;
}

}  // namespace cloister
