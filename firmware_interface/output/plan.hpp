#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// A grid seen from above in which every cell belongs to one submap, the one with the most points
/// in it, or to none.
struct PlanLayer {
  double cell_m = 0;
  int columns = 0, rows = 0;  ///< row 0 is the south (smallest y)
  /// [rows x columns], index into MissionRecord::submaps, -1 for none.
  std::vector<std::int32_t> owner;
};

/// A rectangle of cells with one owner.
struct PlanRectangle {
  std::int32_t owner = -1;
  int column = 0, row = 0, width = 0, height = 0;
};

/// One storey as it is drawn.
struct StoreyPlan {
  struct Label {
    SubmapId id = kNoSubmap;
    Eigen::Vector2d at_M = Eigen::Vector2d::Zero();  ///< well inside the submap's own area
  };
  double floor_z_m = 0;       ///< height of the floor in M, where the path is
  PlanLayer floor;            ///< ground that was seen
  PlanLayer walls;            ///< what stands 0.3 to 2 m above it
  std::vector<Label> labels;  ///< one a submap at most, the large ones first
  std::vector<std::vector<Eigen::Vector2d>> path_M;  ///< where the sensor went, in pieces
  /// Ends of the whole path, where they are on this storey.
  std::optional<Eigen::Vector2d> start_M, end_M;
};

/// What a mission's map looks like from above, a drawing per storey, all in one frame and scale.
struct Plan {
  /// The frame of the drawings; the corners are equal when there is nothing to draw.
  Eigen::Vector2d min_M = Eigen::Vector2d::Zero();
  Eigen::Vector2d max_M = Eigen::Vector2d::Zero();
  std::vector<StoreyPlan> storeys;  ///< bottom up
  [[nodiscard]] bool is_empty() const { return max_M.x() <= min_M.x(); }
};

/// Cuts each storey between floor and ceiling, relative to the ground under the path, so that walls
/// show. A mission of which such a cut holds nothing is drawn from all its points. Cells grow with
/// the place: the drawing stays small.
[[nodiscard]] Plan make_plan(const MissionRecord& record);

/// The cells of a layer merged into rectangles: runs along a row,
/// stacked where the next row has the same run.
[[nodiscard]] std::vector<PlanRectangle> merge_cells(const PlanLayer& layer);

}  // namespace cloister
