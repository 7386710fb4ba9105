#pragma once

#include <filesystem>

#include "firmware_interface/map/map_contents.hpp"
#include "firmware_interface/map/ply_file.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// How deep meshes are drawn (see extract_mesh). At 1 the two sides of a sheet one voxel thick would meet.
inline constexpr double kSurfaceDepth = 0.75;

/// Leaves `submaps/<id>.ply` for every submap and `mesh.ply` with all of them in `out_dir`, in M,
/// coloured by submap. Files of submaps that this map does not have are removed from `submaps/`.
/// Needs memory for one submap's mesh at a time. Fails with kResource when a file cannot be written
/// or a mesh has more vertices than PLY can count.
[[nodiscard]] Result<void> write_meshes(const std::filesystem::path& out_dir, const MapView& map);

/// Writes the mesh of all submaps to one file; needs memory for all of them at once.
[[nodiscard]] Result<void> write_mesh_ply(const std::filesystem::path& path, const MapView& map);

/// Float, unless the map reaches too far from M's origin.
[[nodiscard]] PlyReal ply_real_for(const MapView& map);

}  // namespace cloister
