#include "firmware_interface/output/plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware_interface/output/plan_layer.hpp"
#include "firmware_interface/output/storeys.hpp"

namespace cloister {
namespace {

constexpr double kFloorBelow_m = 0.15;  // further down is the ceiling of the storey below
constexpr double kFloorAbove_m = 0.3;
constexpr double kWallTop_m = 2.0;
constexpr double kMargin_m = 1.0;
constexpr std::size_t kMaxRectangles = 50'000;  // about a megabyte of SVG

enum class Part { kFloor, kWall };

// A surface point where it is drawn.
struct PlanPoint {
  float x_M = 0, y_M = 0;
  std::int32_t submap = -1;
  std::int32_t storey = 0;
  Part part = Part::kWall;
};

template <typename Visit>
void for_each_surface_point(const MissionRecord& record, const Visit& visit) {
  for (std::size_t i = 0; i < record.submaps.size(); ++i) {
    for (const Eigen::Vector3f& p_M : record.submaps[i].surface_M) {
      if (p_M.allFinite()) visit(p_M, static_cast<std::int32_t>(i));
    }
  }
}

// From the sensor down to the ground: the commonest difference between path and what lies below.
double carrying_height_m(const MissionRecord& record, const std::vector<GroundLevel>& levels) {
  constexpr double kLowest_m = 0.2, kBin_m = 0.1;
  struct Bin {
    std::int64_t count = 0;
    double sum_m = 0;
  };
  std::array<Bin, 28> histogram = {};
  for_each_surface_point(record, [&](const Eigen::Vector3f& p_M, std::int32_t) {
    for (const GroundLevel& level : levels) {
      const double drop_m = level.sensor_z(p_M.x(), p_M.y()) - p_M.z() - kLowest_m;
      if (drop_m < 0 || drop_m >= kBin_m * histogram.size()) continue;
      if (!level.is_near_path(p_M.x(), p_M.y())) continue;
      Bin& bin = histogram[static_cast<std::size_t>(drop_m / kBin_m)];
      ++bin.count;
      bin.sum_m += drop_m;
    }
  });
  const auto mode = std::max_element(histogram.begin(), histogram.end(),
                                     [](const Bin& a, const Bin& b) { return a.count < b.count; });
  return mode->count == 0 ? 1.0 : kLowest_m + mode->sum_m / static_cast<double>(mode->count);
}

std::vector<PlanPoint> slice(const MissionRecord& record, const std::vector<GroundLevel>& levels,
                             double carrying_m) {
  std::vector<PlanPoint> points;
  for_each_surface_point(record, [&](const Eigen::Vector3f& p_M, std::int32_t submap) {
    for (std::size_t s = 0; s < levels.size(); ++s) {
      const double height_m = p_M.z() - (levels[s].sensor_z(p_M.x(), p_M.y()) - carrying_m);
      if (height_m > kWallTop_m) continue;
      if (height_m < -kFloorBelow_m && s > 0) continue;
      points.push_back({p_M.x(), p_M.y(), submap, static_cast<std::int32_t>(s),
                        height_m < kFloorAbove_m ? Part::kFloor : Part::kWall});
    }
  });
  if (!points.empty()) return points;
  for_each_surface_point(record, [&](const Eigen::Vector3f& p_M, std::int32_t submap) {
    points.push_back({p_M.x(), p_M.y(), submap, 0, Part::kWall});
  });
  return points;
}

// The frame of the drawing: all of the path, and all points but the outermost half percent on each
// side, so that a stray return far away does not shrink the place to a dot.
void frame(const MissionRecord& record, const std::vector<PlanPoint>& points, Plan& plan) {
  Eigen::AlignedBox2d box;
  for (const auto& [stamp, T_M_L] : record.path_M) {
    if (is_finite(T_M_L)) box.extend(T_M_L.translation().head<2>());
  }
  const auto extend = [&](auto coordinate, int axis) {
    std::vector<float> values;
    values.reserve(points.size());
    for (const PlanPoint& p : points) values.push_back(p.*coordinate);
    const auto low = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 200);
    const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(values.size() / 200);
    std::nth_element(values.begin(), low, values.end());
    box.min()[axis] = std::min(box.min()[axis], static_cast<double>(*low));
    std::nth_element(values.begin(), high, values.end());
    box.max()[axis] = std::max(box.max()[axis], static_cast<double>(*high));
  };
  if (!points.empty()) {
    extend(&PlanPoint::x_M, 0);
    extend(&PlanPoint::y_M, 1);
  }
  if (box.isEmpty()) return;
  plan.min_M = box.min().array() - kMargin_m;
  plan.max_M = box.max().array() + kMargin_m;
}

// Both layers of every storey at one cell size; how many rectangles they take.
std::size_t rasterise(const std::vector<PlanPoint>& points, double cell_m, Plan& plan) {
  std::size_t rectangles = 0;
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    std::vector<LayerPoint> floor, walls;
    for (const PlanPoint& p : points) {
      if (p.storey != static_cast<std::int32_t>(s)) continue;
      (p.part == Part::kFloor ? floor : walls).push_back({p.x_M, p.y_M, p.submap});
    }
    StoreyPlan& storey = plan.storeys[s];
    // The floor is a wash behind the walls: coarser, the holes between the sensor's rings closed.
    storey.floor = make_layer(floor, plan.min_M, plan.max_M, 2 * cell_m);
    fill_holes(storey.floor, 4);
    smooth_owners(storey.floor, 4);
    storey.walls = make_layer(walls, plan.min_M, plan.max_M, cell_m);
    close_gaps(storey.walls);
    smooth_owners(storey.walls, 3);
    rectangles += merge_cells(storey.floor).size() + merge_cells(storey.walls).size();
  }
  return rectangles;
}

void place_labels(const MissionRecord& record, Plan& plan) {
  std::vector<std::int64_t> most_cells(record.submaps.size(), 0);
  std::vector<std::vector<LayerRegion>> regions;
  for (const StoreyPlan& storey : plan.storeys) {
    regions.push_back(find_regions(storey.floor, storey.walls, record.submaps.size()));
    for (std::size_t i = 0; i < most_cells.size(); ++i) {
      most_cells[i] = std::max(most_cells[i], regions.back()[i].cells);
    }
  }
  const double clearance_m = 0.05 * (plan.max_M - plan.min_M).maxCoeff();
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < record.submaps.size(); ++i) {
      // A glimpse of another storey through the stairwell needs no name there.
      if (regions[s][i].cells > 0 && 4 * regions[s][i].cells >= most_cells[i]) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return regions[s][a].cells > regions[s][b].cells;
    });
    std::vector<StoreyPlan::Label>& labels = plan.storeys[s].labels;
    for (const std::size_t i : order) {
      const Eigen::Vector2d at_M = plan.min_M + regions[s][i].inside_m;
      const bool is_clear = std::all_of(labels.begin(), labels.end(), [&](const auto& other) {
        return (other.at_M - at_M).norm() > clearance_m;
      });
      if (is_clear) labels.push_back({record.submaps[i].id, at_M});
    }
  }
}

void trace_path(const MissionRecord& record, const Storeys& found, Plan& plan) {
  const double step_m = std::max(0.1, 0.003 * (plan.max_M - plan.min_M).maxCoeff());
  StoreyPlan* current = nullptr;
  Eigen::Vector2d last_M;
  for (std::size_t k = 0; k < record.path_M.size(); ++k) {
    const Pose& T_M_L = record.path_M[k].second;
    if (!is_finite(T_M_L)) continue;
    last_M = T_M_L.translation().head<2>();
    StoreyPlan& storey = plan.storeys[found.of_pose[k]];
    if (current == nullptr) storey.start_M = last_M;
    if (current != &storey) storey.path_M.emplace_back();
    current = &storey;
    std::vector<Eigen::Vector2d>& piece = storey.path_M.back();
    if (piece.empty() || (piece.back() - last_M).norm() >= step_m) piece.push_back(last_M);
  }
  if (current == nullptr) return;
  current->end_M = last_M;
  current->path_M.back().push_back(last_M);
}

}  // namespace

Plan make_plan(const MissionRecord& record) {
  Plan plan;
  const Storeys found = find_storeys(record.path_M);
  plan.storeys.resize(found.storeys.size());

  Eigen::AlignedBox2d everything;
  for_each_surface_point(record, [&](const Eigen::Vector3f& p_M, std::int32_t) {
    everything.extend(p_M.head<2>().cast<double>());
  });
  if (everything.isEmpty()) everything.extend(Eigen::Vector2d::Zero());
  std::vector<GroundLevel> levels;
  for (const Storey& storey : found.storeys) {
    levels.emplace_back(storey, everything.min(), everything.max());
  }
  const double carrying_m = carrying_height_m(record, levels);
  const std::vector<PlanPoint> points = slice(record, levels, carrying_m);
  frame(record, points, plan);
  if (plan.is_empty()) return plan;

  double cell_m =
      std::max(record.config.voxel.voxel_size_m, (plan.max_M - plan.min_M).maxCoeff() / 1400.0);
  const Eigen::Vector2d min_M = plan.min_M;
  for (;; cell_m *= 1.5) {
    plan.min_M = (min_M / (2 * cell_m)).array().floor() * (2 * cell_m);
    if (rasterise(points, cell_m, plan) <= kMaxRectangles) break;
  }
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    plan.storeys[s].floor_z_m = found.storeys[s].sensor_z_m - carrying_m;
  }
  place_labels(record, plan);
  trace_path(record, found, plan);
  return plan;
}

}  // namespace cloister
