#pragma once

#include "mapping/integrate/evidence.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/scan/range_image.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// What a projective integration works on.
struct ProjectiveJob {
  const RangeImage& image;
  const Evidence& evidence;
  double voxel_size_m;
  double max_range_m;
  std::uint64_t scan_number;  ///< counts up
  ScanMarks& marks;  ///< with the returns marked; blocks that are applied here are ticked off
  VoxelPools& pools;
  Volume& volume;
};

/// What it did, in numbers.
struct ProjectiveResult {
  std::size_t nodes_tested = 0;
  std::size_t blocks_free = 0;     ///< decided as a whole
  std::size_t blocks_coarse = 0;   ///< decided by their octants
  std::size_t blocks_mixed = 0;    ///< decided voxel by voxel
  std::size_t voxels_declined = 0;
};

/// Updates free space, coarse to fine. Nodes of 512, 256, ... 4 voxels are held against the range image's bounds:
/// in front of all beams' ends, they are free as a whole; behind all, or outside of the image, nothing is said about
/// them; else their eight children are asked. Inside octants of 4x4x4 voxels that stay undecided, voxel centres are
/// looked up in the image itself, the projection taken as linear across the octant: at half a metre from the sensor that
/// is wrong by less than half a voxel, at three metres by a tenth. A voxel is free when
///
///   - the beam nearest to its centre passes within half a voxel of it, and proves free beyond it (it is `crossed`), or
///   - all four beams around it do. What lies between beams is so filled as long as no edge runs between them; it counts
///     only for voxels that are not occupied (see apply_to_place), so that thin things seen from near are not cleared by
///     beams that miss them from afar.
///
/// Every node is projected with the sensor's pose at the column that looks at it. Blocks where the scan's beginning and
/// end meet are looked up with both poses.
/// Real-time: no allocation. Vectorised for whatever the processor has; every instruction set gives the same map.
[[nodiscard]] ProjectiveResult integrate_projective(const ProjectiveJob& job);

}  // namespace cloister
