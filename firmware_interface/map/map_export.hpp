#pragma once

#include <filesystem>
#include <string>

#include "firmware_interface/map/map_contents.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

struct ExportOptions {
  bool cloud = false;  ///< a .ply holds the occupied voxels' centres instead of the mesh
};

/// Writes the map in the format that the path's suffix names:
///
/// | suffix | content                                                                            |
/// |--------|------------------------------------------------------------------------------------|
/// | `.ply` | mesh of all submaps in M, coloured by submap; with `cloud` the occupied voxels'    |
/// |        | centres in M as x y z red green blue submap (binary)                               |
/// | `.pcd` | the occupied voxels' centres in M as x y z rgb label (binary); the label is the    |
/// |        | submap's id                                                                        |
/// | `.bt`  | OctoMap of M, occupied or free: each voxel as a query at its centre would say,     |
/// |        | submaps combined                                                                   |
/// | `.ot`  | the same with log-odds                                                             |
/// | `.vdb` | OpenVDB: for each submap a float grid of log-odds, `submap_<id>`, with its pose    |
/// |        | in M as the transform                                                              |
///
/// Fails with kUsage for another suffix, or for `cloud` with neither `.ply` nor `.pcd`; with
/// kResource when the file cannot be written or the format cannot hold the map. The file appears
/// when it is complete.
[[nodiscard]] Result<void> export_map(const MapView& map, const std::filesystem::path& path,
                                      const ExportOptions& options = {});

/// The formats behind `export_map` that need a library of their own.
[[nodiscard]] Result<void> export_octomap(const MapView& map, const std::filesystem::path& path,
                                          bool with_log_odds);
/// The nodes of the same tree as a byte stream, without a file's header: what octomap_msgs carries.
[[nodiscard]] Result<std::string> octomap_data(const MapView& map, bool with_log_odds);
[[nodiscard]] Result<void> export_openvdb(const MapView& map, const std::filesystem::path& path);

}  // namespace cloister
