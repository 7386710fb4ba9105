#include "firmware_interface/output/plan_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace cloister {
namespace {

std::int32_t owner_at(const PlanLayer& layer, int column, int row) {
  if (column < 0 || row < 0 || column >= layer.columns || row >= layer.rows) return -1;
  return layer.owner[static_cast<std::size_t>(row) * layer.columns + column];
}

// Steps to the nearest cell of somebody else, in streets and avenues; two sweeps suffice.
std::vector<int> depths(const PlanLayer& layer) {
  std::vector<int> depth(layer.owner.size(), 0);
  const auto relax = [&](int column, int row, int first_dx, int second_dy) {
    const std::size_t i = static_cast<std::size_t>(row) * layer.columns + column;
    if (layer.owner[i] < 0) return 0;
    const auto neighbour = [&](int c, int r) {
      return owner_at(layer, c, r) == layer.owner[i]
                 ? depth[static_cast<std::size_t>(r) * layer.columns + c]
                 : 0;
    };
    return 1 + std::min(neighbour(column + first_dx, row), neighbour(column, row + second_dy));
  };
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      depth[static_cast<std::size_t>(row) * layer.columns + column] = relax(column, row, -1, -1);
    }
  }
  for (int row = layer.rows - 1; row >= 0; --row) {
    for (int column = layer.columns - 1; column >= 0; --column) {
      int& here = depth[static_cast<std::size_t>(row) * layer.columns + column];
      here = std::min(here, relax(column, row, 1, 1));
    }
  }
  return depth;
}

}  // namespace

PlanLayer make_layer(const std::vector<LayerPoint>& points, const Eigen::Vector2d& min_M,
                     const Eigen::Vector2d& max_M, double cell_m) {
  PlanLayer layer;
  layer.cell_m = cell_m;
  layer.columns = static_cast<int>((max_M.x() - min_M.x()) / cell_m) + 1;
  layer.rows = static_cast<int>((max_M.y() - min_M.y()) / cell_m) + 1;
  layer.owner.assign(static_cast<std::size_t>(layer.columns) * layer.rows, -1);

  std::vector<std::pair<std::uint32_t, std::int32_t>> entries;  // cell, submap
  entries.reserve(points.size());
  for (const LayerPoint& p : points) {
    const double column = std::floor((p.x_M - min_M.x()) / cell_m);
    const double row = std::floor((p.y_M - min_M.y()) / cell_m);
    if (column < 0 || row < 0 || column >= layer.columns || row >= layer.rows) continue;
    entries.emplace_back(static_cast<std::uint32_t>(row * layer.columns + column), p.submap);
  }
  std::sort(entries.begin(), entries.end());
  std::size_t best_count = 0;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i;
    while (end < entries.size() && entries[end] == entries[i]) ++end;
    const bool is_new_cell = i == 0 || entries[i - 1].first != entries[i].first;
    if (is_new_cell || end - i > best_count) {
      best_count = end - i;
      layer.owner[entries[i].first] = entries[i].second;
    }
    i = end;
  }
  return layer;
}

void fill_holes(PlanLayer& layer, int passes) {
  for (int pass = 0; pass < passes; ++pass) {
    const PlanLayer before = layer;
    for (int row = 0; row < layer.rows; ++row) {
      for (int column = 0; column < layer.columns; ++column) {
        if (owner_at(before, column, row) >= 0) continue;
        std::array<std::int32_t, 8> around = {};
        std::size_t taken = 0;
        for (int k = 0; k < 9; ++k) {
          const std::int32_t owner = owner_at(before, column + k % 3 - 1, row + k / 3 - 1);
          if (owner >= 0) around[taken++] = owner;
        }
        if (taken < 5) continue;
        const auto end = around.begin() + static_cast<std::ptrdiff_t>(taken);
        const auto most =
            std::max_element(around.begin(), end, [&](std::int32_t a, std::int32_t b) {
              return std::count(around.begin(), end, a) < std::count(around.begin(), end, b);
            });
        layer.owner[static_cast<std::size_t>(row) * layer.columns + column] = *most;
      }
    }
  }
}

void close_gaps(PlanLayer& layer) {
  const PlanLayer before = layer;
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      if (owner_at(before, column, row) >= 0) continue;
      const std::int32_t west = owner_at(before, column - 1, row);
      const std::int32_t south = owner_at(before, column, row - 1);
      std::int32_t& owner = layer.owner[static_cast<std::size_t>(row) * layer.columns + column];
      if (west >= 0 && west == owner_at(before, column + 1, row)) owner = west;
      if (south >= 0 && south == owner_at(before, column, row + 1)) owner = south;
    }
  }
}

void smooth_owners(PlanLayer& layer, int radius) {
  if (layer.owner.empty()) return;
  const PlanLayer before = layer;
  const std::int32_t last = *std::max_element(before.owner.begin(), before.owner.end());
  std::vector<int> votes(static_cast<std::size_t>(last + 1), 0);
  std::vector<std::int32_t> voters;
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      std::int32_t& owner = layer.owner[static_cast<std::size_t>(row) * layer.columns + column];
      if (owner < 0) continue;
      voters.clear();
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          const std::int32_t voter = owner_at(before, column + dx, row + dy);
          if (voter < 0) continue;
          voters.push_back(voter);
          ++votes[static_cast<std::size_t>(voter)];
        }
      }
      for (const std::int32_t voter : voters) {
        if (votes[static_cast<std::size_t>(voter)] > votes[static_cast<std::size_t>(owner)])
          owner = voter;
      }
      for (const std::int32_t voter : voters) votes[static_cast<std::size_t>(voter)] = 0;
    }
  }
}

std::vector<LayerRegion> find_regions(const PlanLayer& floor, const PlanLayer& walls,
                                      std::size_t num_submaps) {
  std::vector<LayerRegion> regions(num_submaps);
  const auto scan = [&](const PlanLayer& layer, bool only_missing, std::int64_t cells_per) {
    const std::vector<int> depth = depths(layer);
    std::vector<int> deepest(num_submaps, 0);
    std::vector<std::int64_t> count(num_submaps, 0);
    for (std::size_t i = 0; i < layer.owner.size(); ++i) {
      if (layer.owner[i] < 0) continue;
      const auto owner = static_cast<std::size_t>(layer.owner[i]);
      if (only_missing && regions[owner].cells > 0) continue;
      ++count[owner];
      if (depth[i] <= deepest[owner]) continue;
      deepest[owner] = depth[i];
      regions[owner].inside_m =
          layer.cell_m * Eigen::Vector2d(static_cast<double>(i % layer.columns) + 0.5,
                                         static_cast<double>(i / layer.columns) + 0.5);
    }
    for (std::size_t s = 0; s < num_submaps; ++s) {
      if (count[s] > 0) regions[s].cells = count[s] / cells_per + 1;
    }
  };
  scan(floor, false, 1);
  scan(walls, true, 4);
  return regions;
}

std::vector<PlanRectangle> merge_cells(const PlanLayer& layer) {
  std::vector<PlanRectangle> rectangles;
  // (column, width) of a run in the row below -> its rectangle
  std::map<std::pair<int, int>, std::size_t> open;
  for (int row = 0; row < layer.rows; ++row) {
    std::map<std::pair<int, int>, std::size_t> still_open;
    for (int column = 0; column < layer.columns;) {
      const std::int32_t owner = owner_at(layer, column, row);
      int end = column + 1;
      while (end < layer.columns && owner_at(layer, end, row) == owner) ++end;
      if (owner >= 0) {
        const std::pair<int, int> run(column, end - column);
        const auto below = open.find(run);
        if (below != open.end() && rectangles[below->second].owner == owner) {
          ++rectangles[below->second].height;
          still_open.insert(*below);
        } else {
          still_open.emplace(run, rectangles.size());
          rectangles.push_back({owner, column, row, end - column, 1});
        }
      }
      column = end;
    }
    open.swap(still_open);
  }
  return rectangles;
}

}  // namespace cloister
