#include "mapping/overlap/hull_query.hpp"

#include <algorithm>

#include "mapping/overlap/convex_overlap.hpp"
#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

/// Voxels, or blocks, of a grid: both ends belong to it.
struct CellRange {
  Eigen::Vector3i low, high;
};

/// Cells that a box meets; one that it only touches belongs to them.
CellRange cells_of(const Eigen::AlignedBox3d& box, double cell_m) {
  constexpr double kTouch = 1e-9;  // of a cell
  return {(box.min() / cell_m - Eigen::Vector3d::Constant(kTouch)).array().floor().cast<int>(),
          (box.max() / cell_m + Eigen::Vector3d::Constant(kTouch)).array().floor().cast<int>()};
}

Eigen::AlignedBox3d cell_box(const Eigen::Vector3i& cell, double cell_m) {
  return {cell.cast<double>() * cell_m, (cell + Eigen::Vector3i::Ones()).cast<double>() * cell_m};
}

/// Calls `visit` for every cell until it returns true; whether it did.
template <typename Visitor>
bool any_cell(const CellRange& range, Visitor&& visit) {
  for (int z = range.low.z(); z <= range.high.z(); ++z) {
    for (int y = range.low.y(); y <= range.high.y(); ++y) {
      for (int x = range.low.x(); x <= range.high.x(); ++x) {
        if (visit(Eigen::Vector3i(x, y, z))) return true;
      }
    }
  }
  return false;
}

/// The voxels of a block that lie within a range of voxels.
CellRange voxels_within(const BlockCoord& block, const CellRange& voxels) {
  const VoxelCoord first = block * kBlockEdge;
  return {first.cwiseMax(voxels.low),
          (first + VoxelCoord::Constant(kBlockEdge - 1)).cwiseMin(voxels.high)};
}

Eigen::AlignedBox3d bounds_of(std::span<const Eigen::Vector3d> points) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& point : points) bounds.extend(point);
  return bounds;
}

Eigen::Vector3d centre_of(const VoxelCoord& voxel, double voxel_m) {
  return (voxel.cast<double>().array() + 0.5) * voxel_m;
}

}  // namespace

HullQuery::HullQuery(const VoxelStore& store, double voxel_size_m, LogOdds lowest, LogOdds highest,
                     std::span<const Submap* const> submaps)
    : store_(store), voxel_size_m_(voxel_size_m), lowest_(lowest), highest_(highest) {
  for (const Submap* submap : submaps) {
    const Eigen::AlignedBox3d bounds_S = known_bounds(store, submap->volume, voxel_size_m);
    if (!bounds_S.isEmpty()) all_.push_back({submap, submap->T_M_S.inverse(), bounds_S});
  }
  // As EvidenceSum wants them.
  std::ranges::sort(all_, {}, [](const Entry& entry) { return entry.submap->id; });
  near_.reserve(all_.size());
  corners_S_.reserve(kMaxCorners);
}

QueryAnswer HullQuery::combined(const Eigen::Vector3d& p_M) const {
  EvidenceSum evidence;
  for (const Entry* entry : near_) {
    const Eigen::Vector3d p_S = entry->T_S_M * p_M;
    if (!entry->bounds_S.contains(p_S)) continue;
    const VoxelCoord voxel = (p_S / voxel_size_m_).array().floor().cast<int>();
    evidence.add(entry->submap->volume.at(store_, voxel), entry->submap->id);
  }
  return evidence.answer(lowest_, highest_);
}

bool HullQuery::is_known(const Eigen::Vector3d& p_M) {
  return std::ranges::any_of(near_, [&](Entry* entry) {
    const Eigen::Vector3d p_S = entry->T_S_M * p_M;
    const VoxelCoord voxel = (p_S / voxel_size_m_).array().floor().cast<int>();
    // Neighbours mostly share a block.
    const BlockCoord block = parent_coord(voxel);
    if (!entry->has_view || entry->viewed != block) {
      entry->has_view = true;
      entry->viewed = block;
      entry->view = entry->submap->volume.view(store_, block);
    }
    return entry->view.at(index_in_block(voxel)) != kUnknownLogOdds;
  });
}

bool HullQuery::find_occupied(const Entry& entry, HullAnswer& answer) const {
  HullTest hull(corners_S_);
  const CellRange voxels = cells_of(bounds_of(corners_S_), voxel_size_m_);
  const CellRange blocks{parent_coord(voxels.low), parent_coord(voxels.high)};
  return any_cell(blocks, [&](const BlockCoord& block) {
    const BlockView view = entry.submap->volume.view(store_, block);
    if (view.block == nullptr && view.coarse <= 0) return false;
    if (hull.is_disjoint_from(cell_box(block, kBlockEdge * voxel_size_m_))) return false;
    return any_cell(voxels_within(block, voxels), [&](const VoxelCoord& voxel) {
      if (view.at(index_in_block(voxel)) <= 0) return false;
      if (hull.is_disjoint_from(cell_box(voxel, voxel_size_m_))) return false;
      const Eigen::Vector3d p_M = entry.submap->T_M_S * centre_of(voxel, voxel_size_m_);
      const QueryAnswer here = combined(p_M);
      if (here.state != VoxelState::kOccupied) return false;
      answer = {VoxelState::kOccupied, p_M, here.submap};
      return true;
    });
  });
}

bool HullQuery::is_coarsely_known(const Eigen::AlignedBox3d& block_M) const {
  return std::ranges::any_of(near_, [&](const Entry* entry) {
    const CellRange blocks =
        cells_of(block_M.transformed(entry->T_S_M), kBlockEdge * voxel_size_m_);
    return !any_cell(blocks, [&](const BlockCoord& block) {
      const BlockView view = entry->submap->volume.view(store_, block);
      return view.block != nullptr || view.known != kAllOctants;
    });
  });
}

bool HullQuery::find_unknown(std::span<const Eigen::Vector3d> corners_M, HullAnswer& answer) {
  HullTest hull(corners_M);
  const CellRange voxels = cells_of(bounds_of(corners_M), voxel_size_m_);
  const CellRange blocks{parent_coord(voxels.low), parent_coord(voxels.high)};
  return any_cell(blocks, [&](const BlockCoord& block) {
    const Eigen::AlignedBox3d box = cell_box(block, kBlockEdge * voxel_size_m_);
    if (is_coarsely_known(box) || hull.is_disjoint_from(box)) return false;
    return any_cell(voxels_within(block, voxels), [&](const VoxelCoord& voxel) {
      const Eigen::Vector3d p_M = centre_of(voxel, voxel_size_m_);
      if (is_known(p_M)) return false;
      if (hull.is_disjoint_from(cell_box(voxel, voxel_size_m_))) return false;
      answer = {VoxelState::kUnknown, p_M, kNoSubmap};
      return true;
    });
  });
}

std::optional<HullAnswer> HullQuery::at(std::span<const Eigen::Vector3d> corners_M) {
  if (corners_M.empty() || corners_M.size() > kMaxCorners) return std::nullopt;
  for (const Eigen::Vector3d& corner : corners_M) {
    if (!corner.allFinite()) return std::nullopt;
  }
  const Eigen::AlignedBox3d bounds_M = bounds_of(corners_M);
  const Eigen::Vector3d sizes = bounds_M.sizes() / voxel_size_m_ + Eigen::Vector3d::Ones();
  if (sizes.prod() > static_cast<double>(kMaxVoxels)) return std::nullopt;

  near_.clear();
  for (Entry& entry : all_) {
    // A voxel's centre may lie a little outside of the body that touches it.
    Eigen::AlignedBox3d around = bounds_M.transformed(entry.T_S_M);
    around.min().array() -= 2 * voxel_size_m_;
    around.max().array() += 2 * voxel_size_m_;
    if (around.intersects(entry.bounds_S)) near_.push_back(&entry);
  }
  HullAnswer answer;
  for (const Entry* entry : near_) {
    corners_S_.clear();
    for (const Eigen::Vector3d& corner : corners_M) corners_S_.push_back(entry->T_S_M * corner);
    if (find_occupied(*entry, answer)) return answer;
  }
  (void)find_unknown(corners_M, answer);
  return answer;
}

}  // namespace cloister
