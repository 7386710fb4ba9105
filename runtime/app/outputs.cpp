#include "runtime/app/outputs.hpp"

#include <system_error>
#include <vector>

#include "firmware_interface/map/map_file.hpp"
#include "firmware_interface/map/map_mesh.hpp"
#include "firmware_interface/output/mission_output.hpp"

namespace cloister {

MapView view_of(const Pipeline& pipeline, std::span<const Submap* const> submaps) {
  const VoxelConfig& voxel = pipeline.record().config.voxel;
  return {{voxel.voxel_size_m, voxel.log_odds_min, voxel.log_odds_max}, &pipeline.store(), submaps};
}

Result<void> write_outputs(const Pipeline& pipeline, const std::filesystem::path& out) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error)
    return fail(ErrorKind::kResource,
                out.string() + ": cannot make the directory: " + error.message());
  const auto submaps = pipeline.submaps();
  const MapView map = view_of(pipeline, submaps);
  if (auto saved = save_map(out / "map.cloister", map); !saved) return saved;
  if (auto written = write_meshes(out, map); !written) return written;
  return write_mission_outputs(pipeline.record(), out);
}

Result<void> save_present_map(Pipeline& pipeline, const std::filesystem::path& out) {
  pipeline.drain();
  const auto submaps = pipeline.present_submaps();
  return save_map(out / "map.cloister", view_of(pipeline, submaps));
}

}  // namespace cloister
