#pragma once

#include <vector>

#include "firmware_interface/output/plan.hpp"

namespace cloister {

/// A point of a submap seen from above, in M.
struct LayerPoint {
  float x_M = 0, y_M = 0;
  std::int32_t submap = -1;
};

/// Counts points into cells of edge `cell_m` from `min_M` on; each cell goes to the submap with
/// most of them, the first of equals. Points outside of the frame are left out.
[[nodiscard]] PlanLayer make_layer(const std::vector<LayerPoint>& points,
                                   const Eigen::Vector2d& min_M, const Eigen::Vector2d& max_M,
                                   double cell_m);

/// Gives empty cells, five or more of whose eight neighbours are taken, to the owner of most of
/// these; repeated `passes` times.
void fill_holes(PlanLayer& layer, int passes);

/// Gives each empty cell between two cells of one owner, left and right or above and below, to
/// that owner.
void close_gaps(PlanLayer& layer);

/// Gives each taken cell to whoever owns most of the square of `radius` cells around it, its own
/// owner first among equals: where submaps overlap, areas instead of speckle.
/// No cell is taken or freed.
void smooth_owners(PlanLayer& layer, int radius);

/// How much of a layer a submap has, and a point deep inside the largest part of it.
struct LayerRegion {
  std::int64_t cells = 0;
  Eigen::Vector2d inside_m = Eigen::Vector2d::Zero();  ///< from the layer's corner
};

/// One region per submap, in cells of `floor`.
/// Submaps without a floor are found by their walls, a quarter cell each.
[[nodiscard]] std::vector<LayerRegion> find_regions(const PlanLayer& floor, const PlanLayer& walls,
                                                    std::size_t num_submaps);

}  // namespace cloister
