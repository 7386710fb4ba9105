#include "mapping/mesh/drawn_surfaces.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

// How far apart two submaps may show one surface: a third of a metre, at a building's far side as much as a graph that is
// in doubt of the two. Within one submap such steps are drawn.
constexpr int kReachVox = 5;
constexpr int kStepsPerVoxel = 2;

/// Sums of the triangles' normals at each vertex, towards free space.
std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices_S.size(), Eigen::Vector3f::Zero());
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.vertices_S[triangle[0]];
    const Eigen::Vector3f normal =
        (mesh.vertices_S[triangle[1]] - a).cross(mesh.vertices_S[triangle[2]] - a);
    for (const std::uint32_t vertex : triangle) normals[vertex] += normal;
  }
  return normals;
}

/// True when a volume knows something where such a line begins, in its middle or where it ends: most do not, and a line
/// costs four times as much.
bool may_have_surface(const VoxelStore& store, const Volume& volume, const Eigen::Vector3f& p_vox,
                      const Eigen::Vector3f& inwards) {
  for (const int end : {0, -1, 1}) {
    const Eigen::Vector3f at_vox = p_vox + static_cast<float>(end * kReachVox) * inwards;
    const BlockCoord block = parent_coord(at_vox.array().floor().matrix().cast<int>());
    if (!volume.view(store, block).is_unknown()) return true;
  }
  return false;
}

/// True when a volume goes from free to occupied along a line of two reaches, whose middle is `p_vox`.
bool has_surface(const VoxelStore& store, const Volume& volume, const Eigen::Vector3f& p_vox,
                 const Eigen::Vector3f& inwards) {
  bool is_before_free = false;
  for (int i = -kReachVox * kStepsPerVoxel; i <= kReachVox * kStepsPerVoxel; ++i) {
    const Eigen::Vector3f at_vox = p_vox + (static_cast<float>(i) / kStepsPerVoxel) * inwards;
    const LogOdds value = volume.at(store, at_vox.array().floor().matrix().cast<int>());
    if (value > 0 && is_before_free) return true;
    is_before_free = value < 0;
  }
  return false;
}

void remove_triangles(const std::vector<bool>& is_shown, TriangleMesh& mesh) {
  std::erase_if(mesh.triangles, [&](const auto& triangle) {
    return is_shown[triangle[0]] && is_shown[triangle[1]] && is_shown[triangle[2]];
  });
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> new_index(mesh.vertices_S.size(), kUnused);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) new_index[vertex] = 0;
  }
  std::uint32_t num_used = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] == kUnused) continue;
    mesh.vertices_S[num_used] = mesh.vertices_S[i];
    new_index[i] = num_used++;
  }
  mesh.vertices_S.resize(num_used);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = new_index[vertex];
  }
}

}  // namespace

void DrawnSurfaces::add(const Submap& submap) {
  Eigen::AlignedBox3d bounds_S = known_bounds(store_, submap.volume, voxel_size_m_);
  if (bounds_S.isEmpty()) return;
  const double reach_m = kReachVox * voxel_size_m_;
  bounds_S.extend(bounds_S.min() - Eigen::Vector3d::Constant(reach_m));
  bounds_S.extend(bounds_S.max() + Eigen::Vector3d::Constant(reach_m));
  drawn_.push_back({&submap, bounds_S});
}

void DrawnSurfaces::leave_out(const Submap& submap, TriangleMesh& mesh) const {
  if (mesh.triangles.empty()) return;
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const float vox_per_m = 1 / static_cast<float>(voxel_size_m_);
  std::vector<bool> is_shown(mesh.vertices_S.size(), false);
  for (const Drawn& drawn : drawn_) {
    const Eigen::Isometry3f T_drawn_S =
        (drawn.submap->T_M_S.inverse() * submap.T_M_S).cast<float>();
    const Eigen::AlignedBox3f bounds = drawn.bounds_S.cast<float>();
    for (std::size_t i = 0; i < is_shown.size(); ++i) {
      const Eigen::Vector3f p = T_drawn_S * mesh.vertices_S[i];
      if (is_shown[i] || !bounds.contains(p)) continue;
      const Eigen::Vector3f inwards = -(T_drawn_S.linear() * normals[i]).stableNormalized();
      const Volume& volume = drawn.submap->volume;
      is_shown[i] = may_have_surface(store_, volume, vox_per_m * p, inwards) &&
                    has_surface(store_, volume, vox_per_m * p, inwards);
    }
  }
  remove_triangles(is_shown, mesh);
}

}  // namespace cloister
