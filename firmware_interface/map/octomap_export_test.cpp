#include <memory>

#include <doctest/doctest.h>
#include <octomap/OcTree.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/map_query.hpp"

namespace cloister {
namespace {

TEST_CASE("an exported OctoMap answers as the map does") {
  MapBuilder map;
  map.fill_randomly(map.add_submap(0, pose_of(0.13, -0.4, 0.2, 0.7, 0.05)), 3, 200);
  map.fill_randomly(map.add_submap(1), 4, 200);
  const MapQuery query(map.view());
  const ScratchDirectory directory;
  REQUIRE(export_map(map.view(), directory / "map.bt").has_value());
  REQUIRE(export_map(map.view(), directory / "map.ot").has_value());
  octomap::OcTree binary(1.0);
  REQUIRE(binary.readBinary((directory / "map.bt").string()));
  const std::unique_ptr<octomap::AbstractOcTree> read(
      octomap::AbstractOcTree::read((directory / "map.ot").string()));
  auto* full = dynamic_cast<octomap::OcTree*>(read.get());
  REQUIRE(full != nullptr);
  CHECK(full->getResolution() == doctest::Approx(map.info.voxel_size_m));
  CHECK(binary.getResolution() == doctest::Approx(map.info.voxel_size_m));

  int num_occupied = 0, num_free = 0;
  for (int z = -32; z < 32; ++z) {
    for (int y = -90; y < 90; ++y) {
      for (int x = -90; x < 90; ++x) {
        const Eigen::Vector3d p = (VoxelCoord(x, y, z).cast<double>().array() + 0.5) * 0.1;
        const QueryAnswer expected = query.at(p);
        const octomap::OcTreeNode* in_full = full->search(p.x(), p.y(), p.z());
        const octomap::OcTreeNode* in_binary = binary.search(p.x(), p.y(), p.z());
        if (expected.state == VoxelState::kUnknown) {
          REQUIRE(in_full == nullptr);
          REQUIRE(in_binary == nullptr);
          continue;
        }
        REQUIRE(in_full != nullptr);
        REQUIRE(in_binary != nullptr);
        REQUIRE(in_full->getLogOdds() ==
                doctest::Approx(natural_log_odds(expected.log_odds)).epsilon(1e-6));
        const bool is_occupied = expected.state == VoxelState::kOccupied;
        REQUIRE(full->isNodeOccupied(in_full) == is_occupied);
        REQUIRE(binary.isNodeOccupied(in_binary) == is_occupied);
        num_occupied += is_occupied;
        num_free += !is_occupied;
      }
    }
  }
  CHECK(num_occupied > 10'000);
  CHECK(num_free > 10'000);
}

TEST_CASE("coarse free space stays coarse in an OctoMap") {
  MapBuilder map;
  Submap& submap = map.add_submap(0);
  for (int i = 0; i < 8; ++i) map.set_coarse(submap, {i & 1, i >> 1 & 1, i >> 2}, -9);
  const ScratchDirectory directory;
  REQUIRE(export_map(map.view(), directory / "map.bt").has_value());
  octomap::OcTree tree(1.0);
  REQUIRE(tree.readBinary((directory / "map.bt").string()));
  CHECK(tree.getNumLeafNodes() == 1);
}

TEST_CASE("an empty map is an OctoMap without nodes") {
  const MapBuilder map(0, 0);
  const ScratchDirectory directory;
  for (const char* name : {"map.bt", "map.ot"}) {
    REQUIRE(export_map(map.view(), directory / name).has_value());
  }
  octomap::OcTree tree(1.0);
  REQUIRE(tree.readBinary((directory / "map.bt").string()));
  CHECK(tree.size() == 0);
}

TEST_CASE("a map beyond OctoMap's reach is refused and leaves no file") {
  MapBuilder map;
  map.set_coarse(map.add_submap(0, pose_of(4000, 0, 0, 0)), {0, 0, 0}, -9);
  const ScratchDirectory directory;
  const auto exported = export_map(map.view(), directory / "map.bt");
  REQUIRE(!exported.has_value());
  CHECK(exported.error().message.find("3277 m") != std::string::npos);
  CHECK(std::filesystem::is_empty(directory.path()));
}

}  // namespace
}  // namespace cloister
