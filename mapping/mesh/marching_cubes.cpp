#include "mapping/mesh/marching_cubes.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <deque>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "mapping/mesh/cube_cases.hpp"

namespace cloister {
namespace {

constexpr std::uint32_t kNoVertex = 0xffffffffu;
constexpr int kCornerEdge = kBlockEdge + 1;

/// The vertex on each lattice edge whose lower end is in one block: voxel index * 3 + axis.
using EdgeVertices = std::array<std::uint32_t, kBlockVoxels * 3>;

struct Place {
  BlockCoord coord;
  BlockView view;
  EdgeVertices* edge_vertices = nullptr;  ///< made when the first cube needs it
};

[[nodiscard]] bool comes_before(const BlockCoord& a, const BlockCoord& b) {
  return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

/// Visits the blocks in the order z, y, x. The cubes of a block are those whose lowest corner lies
/// in it; they reach into the seven next blocks along x, y and z, which all come later in that
/// order. So once a block's own cubes are done nobody asks for the vertices on its edges again, and
/// their table serves another block.
class Extraction {
 public:
  Extraction(const VoxelStore& store, const Volume& volume, double voxel_size_m, double depth)
      : store_(store), volume_(volume), voxel_size_m_(voxel_size_m), depth_(depth) {
    volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
      places_.push_back({coord, view});
    });
    std::sort(places_.begin(), places_.end(),
              [](const Place& a, const Place& b) { return comes_before(a.coord, b.coord); });
  }

  [[nodiscard]] TriangleMesh run() {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      find_neighbours(i);
      if (may_have_surface() && gather_corners()) visit_cubes();
      release_edge_vertices(places_[i]);
    }
    if (depth_ > 0) draw_deeper();
    return std::move(mesh_);
  }

 private:
  /// Sets neighbours_[d] to the block at offset (d & 1, d >> 1 & 1, d >> 2), or null where nothing
  /// is known. Offsets keep the order of blocks, so one cursor per offset walks through the list
  /// once.
  void find_neighbours(std::size_t place_idx) {
    const BlockCoord& coord = places_[place_idx].coord;
    for (int d = 0; d < 8; ++d) {
      const BlockCoord wanted = coord + BlockCoord(d & 1, d >> 1 & 1, d >> 2);
      std::size_t& cursor = cursors_[d];
      while (cursor < places_.size() && comes_before(places_[cursor].coord, wanted)) ++cursor;
      const bool found = cursor < places_.size() && places_[cursor].coord == wanted;
      neighbours_[d] = found ? &places_[cursor] : nullptr;
    }
  }

  /// False when all known voxels here are sure to have one sign.
  [[nodiscard]] bool may_have_surface() const {
    bool has_free = false, has_occupied = false;
    for (const Place* place : neighbours_) {
      if (place == nullptr) continue;
      if (place->view.block != nullptr) return true;
      has_free = has_free || place->view.coarse < 0;
      has_occupied = has_occupied || place->view.coarse > 0;
    }
    return has_free && has_occupied;
  }

  /// Copies the 9x9x9 log-odds at the corners of the block's cubes; false when they do not change
  /// sign.
  [[nodiscard]] bool gather_corners() {
    for (int z = 0; z < kCornerEdge; ++z) {
      for (int y = 0; y < kCornerEdge; ++y) {
        const int d = (y >> kBlockShift) << 1 | (z >> kBlockShift) << 2;
        LogOdds* row = &corners_[(z * kCornerEdge + y) * kCornerEdge];
        const int first = index_in_block(0, y, z);
        const Place* place = neighbours_[d];
        if (place == nullptr) {
          std::memset(row, kUnknownLogOdds, kBlockEdge);
        } else if (place->view.block != nullptr) {
          std::memcpy(row, &place->view.block->voxels[first], kBlockEdge);
        } else {
          std::memset(row, place->view.at(first), kOctantEdge);
          std::memset(row + kOctantEdge, place->view.at(first + kOctantEdge), kOctantEdge);
        }
        const Place* next = neighbours_[d | 1];
        row[kBlockEdge] = next == nullptr ? kUnknownLogOdds : next->view.at(first);
      }
    }
    const auto [lowest, highest] = std::minmax_element(corners_.begin(), corners_.end());
    return *lowest < 0 && *highest > 0;
  }

  void visit_cubes() {
    for (int z = 0; z < kBlockEdge; ++z) {
      for (int y = 0; y < kBlockEdge; ++y) {
        const LogOdds* row = &corners_[(z * kCornerEdge + y) * kCornerEdge];
        const std::array<const LogOdds*, 4> rows = {row, row + kCornerEdge,
                                                    row + kCornerEdge * kCornerEdge,
                                                    row + kCornerEdge * kCornerEdge + kCornerEdge};
        // Bits 0, 2, 4 and 6 are the cube's corners at its lower x; the corners at its upper x are
        // the same bits of the next column, moved up by one.
        const auto column = [&](int x) {
          int occupied = 0;
          bool is_known = true;
          for (int r = 0; r < 4; ++r) {
            occupied |= (rows[r][x] > 0) << 2 * r;
            is_known = is_known && rows[r][x] != kUnknownLogOdds;
          }
          return is_known ? occupied : -1;
        };
        int lower = column(0);
        for (int x = 0; x < kBlockEdge; ++x) {
          const int upper = column(x + 1);
          if (lower >= 0 && upper >= 0) add_cube({x, y, z}, lower | upper << 1);
          lower = upper;
        }
      }
    }
  }

  void add_cube(const VoxelCoord& local, int occupied_corners) {
    const CubeCase& cube = kCubeCases[occupied_corners];
    for (int t = 0; t < cube.num_triangles; ++t) {
      const auto& edges = cube.triangles[t];
      mesh_.triangles.push_back(
          {vertex_on(local, edges[0]), vertex_on(local, edges[1]), vertex_on(local, edges[2])});
    }
  }

  [[nodiscard]] std::uint32_t vertex_on(const VoxelCoord& cube, int edge) {
    const int corner = lower_corner(edge);
    const int axis = edge / 4;
    const VoxelCoord lower = cube + VoxelCoord(corner & 1, corner >> 1 & 1, corner >> 2);
    Place& owner = *neighbours_[lower.x() >> 3 | lower.y() >> 3 << 1 | lower.z() >> 3 << 2];
    if (owner.edge_vertices == nullptr) owner.edge_vertices = acquire_edge_vertices();
    std::uint32_t& vertex = (*owner.edge_vertices)[index_in_block(lower) * 3 + axis];
    if (vertex == kNoVertex) {
      vertex = static_cast<std::uint32_t>(mesh_.vertices_S.size());
      const VoxelCoord upper = lower + VoxelCoord::Unit(axis);
      const double from = corner_at(lower);
      const double to = corner_at(upper);
      Eigen::Vector3d position_vox =
          (neighbours_[0]->coord * kBlockEdge + lower).cast<double>().array() + 0.5;
      const double crossing = from / (from - to);
      position_vox[axis] += crossing;
      mesh_.vertices_S.push_back((position_vox * voxel_size_m_).cast<float>());
      if (depth_ > 0) {
        const double to_occupied_vox = from < 0 ? 1 - crossing : -crossing;
        to_occupied_S_.push_back(static_cast<float>(to_occupied_vox * voxel_size_m_) *
                                 Eigen::Vector3f::Unit(axis));
      }
    }
    return vertex;
  }

  /// Moves vertices towards the occupied voxel's centre and, where the voxel behind that is occupied as well, on towards
  /// the middle of both. Normals are those of the zero crossing: drawn deep, sheets of one voxel have none.
  void draw_deeper() {
    std::vector<Eigen::Vector3f> normals(mesh_.vertices_S.size(), Eigen::Vector3f::Zero());
    for (const auto& triangle : mesh_.triangles) {
      const Eigen::Vector3f& a = mesh_.vertices_S[triangle[0]];
      const Eigen::Vector3f normal =
          (mesh_.vertices_S[triangle[1]] - a).cross(mesh_.vertices_S[triangle[2]] - a);
      for (const std::uint32_t vertex : triangle) normals[vertex] += normal;
    }
    const auto voxel_m = static_cast<float>(voxel_size_m_);
    const auto depth = static_cast<float>(depth_);
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const Eigen::Vector3f inwards = -normals[i].stableNormalized();
      const Eigen::Vector3f occupied_S = mesh_.vertices_S[i] + to_occupied_S_[i];
      const Eigen::Vector3f behind_S = occupied_S + voxel_m * inwards;
      const bool is_thick =
          volume_.at(store_, (behind_S / voxel_m).array().floor().matrix().cast<int>()) > 0;
      mesh_.vertices_S[i] += depth * to_occupied_S_[i];
      if (is_thick) mesh_.vertices_S[i] += 0.5f * depth * voxel_m * inwards;
    }
  }

  [[nodiscard]] LogOdds corner_at(const VoxelCoord& local) const {
    return corners_[(local.z() * kCornerEdge + local.y()) * kCornerEdge + local.x()];
  }

  [[nodiscard]] EdgeVertices* acquire_edge_vertices() {
    EdgeVertices* table = nullptr;
    if (free_tables_.empty()) {
      table = &tables_.emplace_back();
    } else {
      table = free_tables_.back();
      free_tables_.pop_back();
    }
    table->fill(kNoVertex);
    return table;
  }

  void release_edge_vertices(Place& place) {
    if (place.edge_vertices == nullptr) return;
    free_tables_.push_back(place.edge_vertices);
    place.edge_vertices = nullptr;
  }

  const VoxelStore& store_;
  const Volume& volume_;
  double voxel_size_m_;
  double depth_;
  std::vector<Place> places_;
  std::array<std::size_t, 8> cursors_{};
  std::array<Place*, 8> neighbours_{};
  std::array<LogOdds, kCornerEdge * kCornerEdge * kCornerEdge> corners_{};
  std::deque<EdgeVertices> tables_;
  std::vector<EdgeVertices*> free_tables_;
  TriangleMesh mesh_;
  std::vector<Eigen::Vector3f>
      to_occupied_S_;  ///< of each vertex: from the crossing to the occupied voxel's centre
};

}  // namespace

TriangleMesh extract_mesh(const VoxelStore& store, const Volume& volume, double voxel_size_m,
                          double depth) {
  return Extraction(store, volume, voxel_size_m, depth).run();
}

}  // namespace cloister
