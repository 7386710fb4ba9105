#pragma once

#include <cstdint>

#include "bench/ground_truth/alignment.hpp"
#include "bench/ground_truth/truth.hpp"
#include "bench/simulate/ray_scene.hpp"

namespace cloister {

/// How much of a mesh is drawn twice.
struct DoubledSurface {
  std::size_t samples = 0;
  std::size_t doubled = 0;
  std::size_t far =
      0;  ///< of the doubled: sheets more than 10 cm apart, so not merely in neighbouring voxels

  [[nodiscard]] double share() const { return share_of(doubled); }
  [[nodiscard]] double far_share() const { return share_of(far); }

 private:
  [[nodiscard]] double share_of(std::size_t part) const {
    return samples == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(samples);
  }
};

/// Finds points of the mesh that belong to one of two parallel sheets where the truth has one.
///
/// From every sampled point a ray follows the normal, and one its opposite, for a second sheet 5 to 50 cm away that
/// looks the same way (within 25 degrees): a thin wall's two faces look opposite ways and are not a pair. If the truth
/// has a surface for each sheet, both are near it; if both stand for one surface, their distances from the truth
/// differ by the gap, or add up to it. So a pair counts as doubled when one of its sheets is further from the truth
/// than 5 cm and than 0.45 of the gap, and the other one within half a metre of it. Distances are measured with the SLAM
/// error of the place taken out: else all leaves of a tree that stands a decimetre aside would count, for the truth's own
/// sheets are as near to each other as that.
/// @param mesh_M  corners counter-clockwise seen from free space
/// Errors: those of RayScene::build
[[nodiscard]] Result<DoubledSurface> find_doubled_surface(const TriangleMesh& mesh_M,
                                                          const LocalAlignment& alignment,
                                                          const RayScene& truth_W,
                                                          std::size_t samples, std::uint64_t seed);

}  // namespace cloister
