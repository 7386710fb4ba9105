#pragma once

#include "mapping/integrate/evidence.hpp"
#include "mapping/integrate/scan_marks.hpp"
#include "mapping/scan/range_image.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

struct SharedScan;

/// What a projective integration works on.
struct ProjectiveJob {
  const RangeImage& image;
  const Evidence& evidence;
  double voxel_size_m;
  double max_range_m;
  std::uint64_t scan_number;  ///< counts up from 0
  int bare_turns;             ///< see BareTurns; the first scan and what is near take none
  ScanMarks& marks;  ///< with the returns marked; blocks that are applied here are ticked off
  VoxelPools& pools;
  Volume& volume;
  SharedScan* shared = nullptr;  ///< asks chunks on several threads; the map is the same
};

/// What it did, in numbers.
struct ProjectiveResult {
  std::size_t nodes_tested = 0;
  std::size_t blocks_free = 0;     ///< decided as a whole
  std::size_t blocks_coarse = 0;   ///< bare ones, decided by their octants
  std::size_t blocks_in_turn = 0;  ///< of these, asked because it was their turn
  std::size_t blocks_mixed = 0;    ///< decided voxel by voxel
  std::size_t voxels_declined = 0;

  ProjectiveResult& operator+=(const ProjectiveResult& other) {
    nodes_tested += other.nodes_tested;
    blocks_free += other.blocks_free;
    blocks_coarse += other.blocks_coarse;
    blocks_in_turn += other.blocks_in_turn;
    blocks_mixed += other.blocks_mixed;
    voxels_declined += other.voxels_declined;
    return *this;
  }
};

/// Updates free space, coarse to fine. Nodes of 512, 256, ... 4 voxels are held against the range image's bounds:
/// in front of all beams' ends, they are free as a whole; behind all, or outside of the image, nothing is said about
/// them; else their eight children are asked. A voxel whose centre has to be looked up in the image is free when
///
///   - the beam nearest to its centre passes no further from it than the voxel reaches, both along the image's rows and
///     along its columns, and proves free beyond it (the voxel is `crossed`), or
///   - all four beams around its centre do. What lies between beams is so filled as long as no edge runs between them.
///
/// Near the sensor, where voxels are a fifth wider than pixels, only the first is asked. Further away the second makes free what is
/// not occupied (see add_evidence), and only both together clear what is: thin things seen from near are not cleared by
/// beams that miss them from afar, nor is uneven ground by beams that skim its crests and fall far behind it, while beams
/// beside them end there. What is asked is decided by blocks:
///
///   - Only blocks with returns, or with voxels of their own, are looked up voxel by voxel. In any other, an octant of
///     4x4x4 voxels becomes free when its middle and three quarters of its voxels are: the rest of it is at the border of
///     what is seen.
///   - Where rows are more than a voxel apart, chunks of 64 voxels are asked for free space by every other scan, and from
///     twice as far on by every third, in turn; what is then seen through counts twice or three times, so that what has
///     gone is cleared as soon. Returns count in every scan, and the first scan asks everything.
///   - There, bare blocks are asked for octants by one in two or three of those scans: see BareTurns.
///   - A block in which the last scan changed next to nothing rests: every other scan looks into it, and what is seen
///     through counts twice.
///
/// Every node is projected with the sensor's pose at the column that looks at it; inside blocks and octants the projection
/// is expanded around their middle. Blocks where the scan's beginning and end meet are looked up with both poses.
/// Real-time: no allocation. Vectorised for whatever the processor has; every instruction set gives the same map.
[[nodiscard]] ProjectiveResult integrate_projective(const ProjectiveJob& job);

}  // namespace cloister
