#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "mapping/mesh/triangle_mesh.hpp"
#include "mapping/submap/submap.hpp"
#include "mapping/voxel/voxel_store.hpp"

namespace cloister {

/// The submaps whose meshes have been drawn, so that a surface which several of them know is drawn once.
///
/// Submaps that share a place (see share_places) meet block by block. Where a correction has turned or moved one against
/// the other their blocks overlap at the seam, and where the graph is in doubt nothing is shared at all: drawn as they are,
/// both show the same wall, some voxels apart.
///
/// Threads: one owner; reads the submaps, and needs their owner's permission. Allocates.
class DrawnSurfaces {
 public:
  DrawnSurfaces(const VoxelStore& store, double voxel_size_m)
      : store_(store), voxel_size_m_(voxel_size_m) {}

  /// Takes a submap's triangles away, and vertices that nothing uses any more, where a submap that was added before
  /// changes from free to occupied in the same direction at most five voxels before or behind each of their corners.
  void leave_out(const Submap& submap, TriangleMesh& mesh) const;
  /// The submap's mesh is drawn from now on. It must live as long as this.
  void add(const Submap& submap);

 private:
  struct Drawn {
    const Submap* submap = nullptr;
    Eigen::AlignedBox3d
        bounds_S;  ///< of what it knows, and as far around as surfaces are looked for
  };

  const VoxelStore& store_;
  double voxel_size_m_;
  std::vector<Drawn> drawn_;
};

}  // namespace cloister
