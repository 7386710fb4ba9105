#include <exception>
#include <string>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "firmware_interface/map/atomic_ostream.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/map_query.hpp"

namespace cloister {
namespace {

/// World coordinates of a grid point: voxel v's value stands at its centre, (v + 0.5) * voxel_size
/// in S.
[[nodiscard]] openvdb::math::Transform::Ptr transform_of(const Pose& T_M_S, double voxel_size_m) {
  const Eigen::Matrix3d scaled = T_M_S.linear() * voxel_size_m;
  const Eigen::Vector3d first_centre = T_M_S * Eigen::Vector3d::Constant(0.5 * voxel_size_m);
  // OpenVDB multiplies row vectors from the left, so its matrix is ours transposed.
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix(row, column) = scaled(column, row);
    matrix(3, row) = first_centre[row];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

/// A grid whose active values are the known voxels. Our blocks are OpenVDB's leaves, our coarse
/// nodes its tiles.
[[nodiscard]] openvdb::FloatGrid::Ptr make_grid(const MapView& map, const Submap& submap) {
  openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
  grid->setName("submap_" + std::to_string(submap.id));
  grid->setTransform(transform_of(submap.T_M_S, map.info.voxel_size_m));
  grid->insertMeta("quantity",
                   openvdb::StringMetadata("log-odds of occupancy; inactive is unknown"));
  openvdb::FloatTree& tree = grid->tree();
  submap.volume.for_each_block(*map.store, [&](const BlockCoord& block, const BlockView& view) {
    const BlockCoord low = block * kBlockEdge;
    const openvdb::Coord origin(low.x(), low.y(), low.z());
    if (view.is_uniform()) {
      tree.addTile(1, origin, static_cast<float>(natural_log_odds(view.coarse)), true);
      return;
    }
    openvdb::FloatTree::LeafNodeType* leaf = tree.touchLeaf(origin);
    for (int i = 0; i < kBlockVoxels; ++i) {
      const LogOdds log_odds = view.at(i);
      if (log_odds == kUnknownLogOdds) continue;
      leaf->setValueOn(origin + openvdb::Coord(i & 7, i >> 3 & 7, i >> 6),
                       static_cast<float>(natural_log_odds(log_odds)));
    }
  });
  return grid;
}

}  // namespace

Result<void> export_openvdb(const MapView& map, const std::filesystem::path& path) {
  static_assert(openvdb::FloatTree::LeafNodeType::DIM == kBlockEdge);
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());
  try {
    openvdb::initialize();
    openvdb::GridCPtrVec grids;
    for (const Submap* submap : sorted_submaps(map)) grids.push_back(make_grid(map, *submap));
    AtomicOstream stream(*file);
    openvdb::io::Stream(stream).write(grids);
  } catch (const std::exception& error) {
    // What went wrong with the file says more than what OpenVDB made of it.
    if (auto done = file->write(std::string_view()); !done) return done;
    return fail(ErrorKind::kResource,
                path.string() + ": OpenVDB cannot write the map: " + error.what());
  }
  return file->commit();
}

}  // namespace cloister
