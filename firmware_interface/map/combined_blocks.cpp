#include "firmware_interface/map/combined_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <vector>

#include "firmware_interface/map/map_query.hpp"

namespace cloister {
namespace {

/// A block of M's grid that a submap may know something about.
struct Candidate {
  std::int32_t z, y, x;
  std::int32_t submap_idx;

  friend auto operator<=>(const Candidate&, const Candidate&) = default;
  [[nodiscard]] bool is_same_block(const Candidate& other) const {
    return z == other.z && y == other.y && x == other.x;
  }
};

/// Appends the blocks of M's grid that the submap's blocks meet;
/// false when one lies beyond the bound.
[[nodiscard]] bool add_candidates(const MapView& map, const Submap& submap, int submap_idx,
                                  int max_voxel_coord, std::vector<Candidate>& candidates) {
  const double edge_m = kBlockEdge * map.info.voxel_size_m;
  const double max_block = static_cast<double>(max_voxel_coord) / kBlockEdge;
  // Half the extent of a turned block along M's axes, in blocks. It is a hair less than the truth,
  // so that blocks which only touch do not count: their voxels' centres are far from the border.
  const Eigen::Vector3d half =
      submap.T_M_S.linear().cwiseAbs() * Eigen::Vector3d::Constant(0.5 - 1e-6);
  bool is_within = true;
  submap.volume.for_each_block(*map.store, [&](const BlockCoord& coord, const BlockView&) {
    const Eigen::Vector3d centre_S = (coord.cast<double>().array() + 0.5) * edge_m;
    const Eigen::Vector3d centre = submap.T_M_S * centre_S / edge_m;
    if ((centre - half).minCoeff() < -max_block || (centre + half).maxCoeff() >= max_block) {
      is_within = false;
      return;
    }
    const BlockCoord low = (centre - half).array().floor().cast<int>();
    const BlockCoord high = (centre + half).array().floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) candidates.push_back({z, y, x, submap_idx});
      }
    }
  });
  return is_within;
}

/// Remembers the block of the last look-up, as neighbouring voxels mostly share one.
class VoxelReader {
 public:
  VoxelReader(const VoxelStore& store, const Volume& volume) : store_(store), volume_(volume) {}

  [[nodiscard]] LogOdds at(const VoxelCoord& voxel) {
    const BlockCoord coord = parent_coord(voxel);
    if (!has_view_ || coord != coord_) {
      view_ = volume_.view(store_, coord);
      coord_ = coord;
      has_view_ = true;
    }
    return view_.at(index_in_block(voxel));
  }

 private:
  const VoxelStore& store_;
  const Volume& volume_;
  BlockCoord coord_ = BlockCoord::Zero();
  BlockView view_;
  bool has_view_ = false;
};

}  // namespace

bool for_each_combined_block(const MapView& map, int max_voxel_coord,
                             const std::function<void(const CombinedBlock&)>& visit) {
  const std::vector<const Submap*> submaps = sorted_submaps(map);
  std::vector<Candidate> candidates;
  std::vector<Pose> T_S_M;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const std::size_t first = candidates.size();
    if (!add_candidates(map, *submaps[i], static_cast<int>(i), max_voxel_coord, candidates)) {
      return false;
    }
    const auto begin = candidates.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(begin, candidates.end());
    candidates.erase(std::unique(begin, candidates.end()), candidates.end());
    T_S_M.push_back(submaps[i]->T_M_S.inverse());
  }
  std::sort(candidates.begin(), candidates.end());

  const LogOdds lowest = log_odds_steps(map.info.log_odds_min);
  const LogOdds highest = log_odds_steps(map.info.log_odds_max);
  for (std::size_t begin = 0; begin < candidates.size();) {
    std::size_t end = begin;
    while (end < candidates.size() && candidates[end].is_same_block(candidates[begin])) ++end;
    CombinedBlock block;
    block.coord = {candidates[begin].x, candidates[begin].y, candidates[begin].z};
    std::array<EvidenceSum, kBlockVoxels> evidence;
    for (const Candidate& candidate : std::span(candidates).subspan(begin, end - begin)) {
      const Submap& submap = *submaps[candidate.submap_idx];
      VoxelReader reader(*map.store, submap.volume);
      for (int i = 0; i < kBlockVoxels; ++i) {
        const VoxelCoord voxel_M = block.coord * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
        const Eigen::Vector3d p_M = (voxel_M.cast<double>().array() + 0.5) * map.info.voxel_size_m;
        const Eigen::Vector3d p_S = T_S_M[candidate.submap_idx] * p_M;
        const VoxelCoord voxel_S = (p_S / map.info.voxel_size_m).array().floor().cast<int>();
        evidence[i].add(reader.at(voxel_S), submap.id);
      }
    }
    bool is_known = false;
    for (int i = 0; i < kBlockVoxels; ++i) {
      block.voxels[i] = evidence[i].answer(lowest, highest).log_odds;
      is_known = is_known || block.voxels[i] != kUnknownLogOdds;
    }
    if (is_known) visit(block);
    begin = end;
  }
  return true;
}

}  // namespace cloister
