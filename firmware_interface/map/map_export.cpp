#include "firmware_interface/map/map_export.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <new>
#include <string>

#include "firmware_interface/files/atomic_file.hpp"
#include "firmware_interface/map/map_mesh.hpp"
#include "firmware_interface/map/occupied_points.hpp"
#include "firmware_interface/map/ply_file.hpp"

namespace cloister {
namespace {

[[nodiscard]] Result<void> export_ply_cloud(const MapView& map, const std::filesystem::path& path) {
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const PlyReal real = ply_real_for(map);
  static_cast<void>(file->write(ply_cloud_header(count_occupied(map), real)));
  for_each_occupied_point(map, [&](const Submap& submap, const Eigen::Vector3d& p_M) {
    write_ply_point(p_M, submap_colour(submap.id), submap.id, real, *file);
  });
  return file->commit();
}

struct PcdPoint {
  std::array<float, 3> xyz;
  std::uint32_t rgb;  ///< 0x00rrggbb; declared as a float, as readers of this field expect
  std::uint32_t label;
};
static_assert(sizeof(PcdPoint) == 20);

[[nodiscard]] Result<void> export_pcd(const MapView& map, const std::filesystem::path& path) {
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const std::string count = std::to_string(count_occupied(map));
  static_cast<void>(file->write(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb label\n"
      "SIZE 4 4 4 4 4\nTYPE F F F F U\nCOUNT 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n"));
  for_each_occupied_point(map, [&](const Submap& submap, const Eigen::Vector3d& p_M) {
    const Rgb colour = submap_colour(submap.id);
    const Eigen::Vector3f p = p_M.cast<float>();
    const PcdPoint point = {{p.x(), p.y(), p.z()},
                            static_cast<std::uint32_t>(colour.r << 16 | colour.g << 8 | colour.b),
                            static_cast<std::uint32_t>(submap.id)};
    static_cast<void>(file->write(std::as_bytes(std::span(&point, 1))));
  });
  return file->commit();
}

}  // namespace

Result<void> export_map(const MapView& map, const std::filesystem::path& path,
                        const ExportOptions& options) try {
  const std::string suffix = path.extension().string();
  if (options.cloud && suffix != ".ply" && suffix != ".pcd") {
    return fail(
        ErrorKind::kUsage,
        path.string() + ": only .ply and .pcd can hold a cloud; give one of these suffixes");
  }
  if (suffix == ".ply")
    return options.cloud ? export_ply_cloud(map, path) : write_mesh_ply(path, map);
  if (suffix == ".pcd") return export_pcd(map, path);
  if (suffix == ".bt") return export_octomap(map, path, false);
  if (suffix == ".ot") return export_octomap(map, path, true);
  if (suffix == ".vdb") return export_openvdb(map, path);
  return fail(
      ErrorKind::kUsage,
      path.string() + ": unknown suffix '" + suffix +
          "'; use .ply (mesh or cloud), .pcd (cloud), .bt or .ot (OctoMap) or .vdb (OpenVDB)");
} catch (const std::bad_alloc&) {
  return fail(ErrorKind::kResource, path.string() + ": the export does not fit into memory");
}

}  // namespace cloister
