#include "firmware_interface/map/map_query.hpp"

#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {

MapQuery::MapQuery(const MapView& map)
    : info_(map.info),
      lowest_(log_odds_steps(map.info.log_odds_min)),
      highest_(log_odds_steps(map.info.log_odds_max)),
      store_(map.store) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(info_.voxel_size_m);
  for (const Submap* submap : sorted_submaps(map)) {
    const Eigen::AlignedBox3d box_S = known_bounds(*store_, submap->volume, info_.voxel_size_m);
    if (box_S.isEmpty()) continue;
    Eigen::AlignedBox3d box_M;
    for (int corner = 0; corner < 8; ++corner) {
      box_M.extend(submap->T_M_S *
                   box_S.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    }
    // A point on the very border may round to either side on its way through T_S_M.
    box_M.min() -= margin;
    box_M.max() += margin;
    entries_.push_back({box_M, box_S, submap->T_M_S.inverse(), submap});
  }
}

QueryAnswer MapQuery::at(const Eigen::Vector3d& p_M) const {
  EvidenceSum evidence;
  for (const Entry& entry : entries_) {
    if (!entry.box_M.contains(p_M)) continue;
    const Eigen::Vector3d p_S = entry.T_S_M * p_M;
    if (!entry.box_S.contains(p_S)) continue;
    const VoxelCoord voxel = (p_S / info_.voxel_size_m).array().floor().cast<int>();
    evidence.add(entry.submap->volume.at(*store_, voxel), entry.submap->id);
  }
  return evidence.answer(lowest_, highest_);
}

}  // namespace cloister
