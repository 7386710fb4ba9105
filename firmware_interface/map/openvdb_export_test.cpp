#include <doctest/doctest.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/map_query.hpp"

namespace cloister {
namespace {

TEST_CASE("OpenVDB reads back one grid per submap with its voxels and pose") {
  MapBuilder map;
  map.fill_randomly(map.add_submap(4, pose_of(30.13, -0.4, 0.2, 0.7, 0.05)), 3);
  map.fill_randomly(map.add_submap(0), 4);
  map.add_submap(2);  // knows nothing
  const ScratchDirectory directory;
  REQUIRE(export_map(map.view(), directory / "map.vdb").has_value());

  openvdb::initialize();
  openvdb::io::File file((directory / "map.vdb").string());
  file.open();
  for (const Submap& submap : map.submaps) {
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(
        file.readGrid("submap_" + std::to_string(submap.id)));
    REQUIRE(grid != nullptr);
    const auto accessor = grid->getConstAccessor();
    std::size_t num_known = 0;
    submap.volume.for_each_block(map.store, [&](const BlockCoord& block, const BlockView& view) {
      for (int i = 0; i < kBlockVoxels; ++i) {
        const VoxelCoord v = block * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
        const openvdb::Coord coord(v.x(), v.y(), v.z());
        const bool is_known = view.at(i) != kUnknownLogOdds;
        REQUIRE(accessor.isValueOn(coord) == is_known);
        REQUIRE(accessor.getValue(coord) == static_cast<float>(natural_log_odds(view.at(i))));
        num_known += is_known;
        if (i != 0) continue;
        const openvdb::Vec3d world = grid->indexToWorld(coord);
        const Eigen::Vector3d centre_S = (v.cast<double>().array() + 0.5) * map.info.voxel_size_m;
        const Eigen::Vector3d expected = submap.T_M_S * centre_S;
        REQUIRE((Eigen::Vector3d(world.x(), world.y(), world.z()) - expected).norm() < 1e-9);
      }
    });
    CHECK(grid->activeVoxelCount() == num_known);
  }
  CHECK(file.getGrids()->size() == 3);
}

TEST_CASE("OpenVDB sees no difference between a partly known coarse node and the same voxels") {
  MapBuilder map;
  Submap& coarse = map.add_submap(0);
  Submap& plain = map.add_submap(1);
  for (const int known : {0x01, 0x80, 0x35, 0x7f, 0xff}) {
    map.set_coarse(coarse, {known, 0, 0}, -9, static_cast<OctantMask>(known));
    map.set_plain(plain, {known, 0, 0}, -9, static_cast<OctantMask>(known));
  }
  const ScratchDirectory directory;
  REQUIRE(export_map(map.view(), directory / "map.vdb").has_value());
  openvdb::initialize();
  openvdb::io::File file((directory / "map.vdb").string());
  file.open();
  const auto a = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("submap_0"));
  const auto b = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("submap_1"));
  CHECK(a->activeVoxelCount() == (1 + 1 + 4 + 7 + 8) * kOctantVoxels);
  CHECK(a->activeVoxelCount() == b->activeVoxelCount());
  const auto in_a = a->getConstAccessor();
  for (auto voxel = b->cbeginValueOn(); voxel; ++voxel) {
    CHECK(in_a.isValueOn(voxel.getCoord()));
    CHECK(in_a.getValue(voxel.getCoord()) == *voxel);
  }
}

TEST_CASE("an OpenVDB file that cannot be written is reported") {
  const MapBuilder map(0, 0);
  const auto exported = export_map(map.view(), "no/such/folder/map.vdb");
  REQUIRE(!exported.has_value());
  CHECK(exported.error().kind == ErrorKind::kResource);
  CHECK(exported.error().message.find("no/such/folder/map.vdb") != std::string::npos);
}

}  // namespace
}  // namespace cloister
