#include "mapping/fuse/place_sharing.hpp"

#include <utility>

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr float kBlockM = 0.52f;

/// Two submaps whose sensors stood `2 * half_gap` blocks apart along x, each side of M's origin.
struct TwoSubmaps {
  explicit TwoSubmaps(std::size_t num_blocks = 2000) : store(num_blocks, 64), pools(store) {
    pools.take_all();
    a.path.add({-10 * kBlockM, 0, 0});
    b.path.add({10 * kBlockM, 0, 0});
  }
  /// A block with a surface through its middle, whatever side of it is free.
  void add_wall(Submap& submap, const BlockCoord& coord, int thickness_vox = 4) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = submap.volume.make_place(pools, coord, &chunk);
    Block* block = submap.volume.make_block(pools, *chunk, *place);
    for (int i = 0; i < kBlockVoxels; ++i)
      block->voxels[i] = (i & 7) < thickness_vox ? LogOdds{30} : LogOdds{-30};
  }
  void add_free(Submap& submap, const BlockCoord& coord) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = submap.volume.make_place(pools, coord, &chunk);
    submap.volume.set_coarse(pools, *chunk, *place, -20, kAllOctants);
  }
  [[nodiscard]] LogOdds at(const Submap& submap, const BlockCoord& coord) const {
    return submap.volume.at(store, coord * kBlockEdge);
  }
  [[nodiscard]] std::optional<std::size_t> share(const Pose& T_a_b = Pose::Identity(),
                                                 SharingTrust trust = SharingTrust::kFull) {
    return share_places(a, b, T_a_b, config, pools, trust);
  }
  VoxelConfig config;
  VoxelStore store;
  VoxelPools pools;
  Submap a, b;
};

/// A pose of b in a's frame, so many voxels along x.
Pose aside(int num_vox) {
  Pose T_a_b = Pose::Identity();
  T_a_b.translation().x() = num_vox * VoxelConfig{}.voxel_size_m;
  return T_a_b;
}

TEST_CASE(
    "a place that two submaps know goes to the one whose sensor came nearer, whose word stands") {
  TwoSubmaps s;
  for (int x = -10; x < 10; ++x) {
    s.add_wall(s.a, {x, 2, 0});
    s.add_wall(s.b, {x, 2, 0});
    s.add_free(s.a, {x, 1, 0});
    s.add_free(s.b, {x, 1, 0});
  }
  CHECK(s.share() == 40);
  for (int x = -10; x < 10; ++x) {
    CAPTURE(x);
    const Submap& keeper = x < 0 ? s.a : s.b;
    const Submap& giver = x < 0 ? s.b : s.a;
    CHECK(s.at(keeper, {x, 2, 0}) == 30);
    CHECK(s.at(keeper, {x, 1, 0}) == -20);
    CHECK(s.at(giver, {x, 2, 0}) == kUnknownLogOdds);
    CHECK(s.at(giver, {x, 1, 0}) == kUnknownLogOdds);
  }
  CHECK(s.a.volume.num_blocks() == 10);
  CHECK(s.b.volume.num_blocks() == 10);
  CHECK(s.pools.blocks.num_free() == s.store.num_blocks() - 20);
  CHECK(s.share() == 0);
}

TEST_CASE("what is given fills in what the nearer submap has not seen") {
  TwoSubmaps s;
  s.add_wall(s.a, {5, 0, 0});
  s.add_wall(s.b, {5, 0, 0});
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.b.volume.make_place(s.pools, {5, 0, 0}, &chunk);
  Block* block = s.b.volume.make_block(s.pools, *chunk, *place);
  for (int i = 0; i < kBlockVoxels / 4; ++i) block->voxels[i] = kUnknownLogOdds;
  block->voxels[kBlockVoxels - 1] = 5;
  CHECK(s.share() == 1);
  CHECK(s.at(s.b, {5, 0, 0}) == 30);
  CHECK(s.b.volume.at(s.store, VoxelCoord(47, 7, 7)) == 5);
  CHECK(s.a.volume.num_blocks() == 0);
}

TEST_CASE("what only one submap knows, or the other only touches, stays where it is") {
  TwoSubmaps s;
  s.add_wall(s.a, {5, 0, 0});
  s.add_wall(s.a, {6, 0, 0});
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.b.volume.make_place(s.pools, {6, 0, 0}, &chunk);
  s.b.volume.make_block(s.pools, *chunk, *place)->voxels[7] = -10;
  CHECK(s.share() == 0);
  CHECK(s.at(s.a, {5, 0, 0}) == 30);
  CHECK(s.at(s.a, {6, 0, 0}) == 30);
}

TEST_CASE("a surface that the nearer submap sees elsewhere stays where it is") {
  TwoSubmaps s;
  s.add_wall(s.a, {5, 0, 0});
  s.add_wall(s.b, {5, 0, 0});
  // A block aside b has seen through.
  Pose T_a_b = Pose::Identity();
  T_a_b.translation().y() = 0.52;
  s.add_free(s.b, {5, -1, 0});
  CHECK(s.share(T_a_b) == 0);
  CHECK(s.at(s.a, {5, 0, 0}) == 30);
  T_a_b.translation().y() = 0.13;
  s.add_wall(s.b, {5, -1, 0});
  CHECK(s.share(T_a_b) == 1);
  CHECK(s.at(s.a, {5, 0, 0}) == kUnknownLogOdds);
}

TEST_CASE("of a wall that the nearer submap sees two voxels aside, only the nearer view is left") {
  TwoSubmaps s;
  s.add_wall(s.a, {5, 0, 0}, 1);
  s.add_wall(s.b, {5, 0, 0}, 1);
  const Pose T_a_b = aside(-2);
  const std::size_t blocks_of_b = s.b.volume.num_blocks();
  CHECK(s.share(T_a_b) == 1);
  CHECK(s.a.volume.num_blocks() == 0);
  CHECK(s.b.volume.num_blocks() == blocks_of_b);
  // Nothing of a's view was filled in behind b's wall.
  CHECK(s.b.volume.at(s.store, VoxelCoord(48, 0, 0)) == kUnknownLogOdds);
}

TEST_CASE("of two submaps that may yet move, the further one drops its copies and gives nothing") {
  for (const SharingTrust trust : {SharingTrust::kUncertain, SharingTrust::kContradicted}) {
    TwoSubmaps s;
    s.add_wall(s.a, {5, 0, 0});
    s.add_wall(s.b, {5, 0, 0});
    // Of this block b knows half: to give a's would fill in the rest.
    s.add_wall(s.a, {5, 2, 0});
    s.add_wall(s.b, {5, 2, 0});
    Chunk* chunk = nullptr;
    std::uint32_t* place = s.b.volume.make_place(s.pools, {5, 2, 0}, &chunk);
    Block* block = s.b.volume.make_block(s.pools, *chunk, *place);
    for (int i = 0; i < kBlockVoxels / 2; ++i) block->voxels[i] = kUnknownLogOdds;
    const std::size_t blocks_of_b = s.b.volume.num_blocks();
    CHECK(s.share(Pose::Identity(), trust) == 1);
    CHECK(s.at(s.a, {5, 0, 0}) == kUnknownLogOdds);
    CHECK(s.at(s.b, {5, 0, 0}) == 30);
    CHECK(s.at(s.a, {5, 2, 0}) == 30);
    CHECK(s.at(s.b, {5, 2, 0}) == kUnknownLogOdds);
    CHECK(s.b.volume.num_blocks() == blocks_of_b);
    CHECK(s.share(Pose::Identity(), trust) == 0);
  }
}

TEST_CASE(
    "of two views of a wall that the graph is sure of, the nearer one is left, however far aside") {
  for (const int num_vox : {0, -2, -5}) {
    CAPTURE(num_vox);
    TwoSubmaps s;
    s.add_wall(s.a, {5, 0, 0}, 1);
    s.add_wall(s.b, {5, 0, 0}, 1);
    s.add_free(s.b, {6, 0, 0});
    CHECK(s.share(aside(num_vox), SharingTrust::kContradicted) == 1u);
    CHECK(s.a.volume.num_blocks() == 0);
    CHECK(s.b.volume.num_blocks() == 1);
  }
}

TEST_CASE("where the graph owns its doubt, a copy two voxels aside goes, and another view stays") {
  for (const auto& [num_vox, num_dropped] : {std::pair{-2, 1u}, {-5, 0u}}) {
    TwoSubmaps s;
    s.add_wall(s.a, {5, 0, 0}, 1);
    s.add_wall(s.b, {5, 0, 0}, 1);
    s.add_free(s.b, {6, 0, 0});
    CHECK(s.share(aside(num_vox), SharingTrust::kUncertain) == num_dropped);
    CHECK(s.a.volume.num_blocks() == 1 - num_dropped);
    CHECK(s.b.volume.num_blocks() == 1);
  }
}

TEST_CASE("a glimpse goes without trust where the nearer one knows more, whatever it shows") {
  // Of eight rows that the nearer one knows, as much as the further one, or half as much again.
  for (const auto& [trust, most_rows] :
       {std::pair{SharingTrust::kUncertain, 5}, {SharingTrust::kContradicted, 8}}) {
    for (const int rows : {5, 7, 8}) {
      CAPTURE(rows);
      TwoSubmaps s;
      s.add_free(s.b, {5, 0, 0});
      Chunk* chunk = nullptr;
      std::uint32_t* place = s.a.volume.make_place(s.pools, {5, 0, 0}, &chunk);
      Block* block = s.a.volume.make_block(s.pools, *chunk, *place);
      for (int i = 0; i < rows * kBlockVoxels / kBlockEdge; ++i) block->voxels[i] = 30;
      CHECK(s.share(Pose::Identity(), trust) == (rows <= most_rows ? 1u : 0u));
      CHECK(s.b.volume.num_blocks() == 0);
      CHECK(s.at(s.b, {5, 0, 0}) == -20);
    }
  }
}

TEST_CASE("a chunk with a few copies in it goes to the submap that has more of its place, near or far") {
  for (const int num_of_b : {7, 8}) {
    for (const SharingTrust trust : {SharingTrust::kFull, SharingTrust::kUncertain}) {
      CAPTURE(num_of_b);
      TwoSubmaps s;
      for (int x = -8; x < -8 + num_of_b; ++x) s.add_wall(s.b, {x, 0, 0});
      s.add_wall(s.a, {-8, 0, 0});  // a copy
      s.add_wall(s.a, {-8, 4, 0});  // which b does not show
      // a is the nearer one: b's copy goes to it where neither has much.
      const bool goes_to_b = num_of_b == 8 && trust == SharingTrust::kFull;
      CHECK(s.share(Pose::Identity(), trust) == 1);
      CHECK(s.at(s.a, {-8, 0, 0}) == (goes_to_b ? kUnknownLogOdds : 30));
      CHECK(s.at(s.b, {-8, 0, 0}) == (goes_to_b ? 30 : kUnknownLogOdds));
      CHECK(s.at(s.a, {-8, 4, 0}) == 30);
    }
  }
}

TEST_CASE("a wall goes along with the free space before it, where nobody else shows it") {
  TwoSubmaps s;
  for (Submap* submap : {&s.a, &s.b}) {
    s.add_free(*submap, {5, 0, 0});
    s.add_free(*submap, {5, 1, 0});
  }
  // Before the one wall free space goes to b, before the other it stays.
  s.add_wall(s.a, {6, 0, 0}, kBlockEdge);
  s.add_wall(s.a, {-9, 0, 0}, kBlockEdge);
  s.add_free(s.a, {-10, 0, 0});
  CHECK(s.share() == 2);
  CHECK(s.at(s.b, {5, 0, 0}) == -20);
  CHECK(s.at(s.b, {6, 0, 0}) == 30);
  CHECK(s.at(s.a, {5, 0, 0}) == kUnknownLogOdds);
  CHECK(s.at(s.a, {-9, 0, 0}) == 30);
  CHECK(s.at(s.b, {-9, 0, 0}) == kUnknownLogOdds);
}

TEST_CASE("of a glimpse, what the other does not know is given, not lost") {
  TwoSubmaps s;
  for (int x = -8; x < 0; ++x) s.add_wall(s.b, {x, 0, 0});
  // a is the nearer one, has little of the chunk, and has seen free space where b knows nothing.
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.a.volume.make_place(s.pools, {-8, 5, 0}, &chunk);
  s.a.volume.make_block(s.pools, *chunk, *place)->voxels[0] = -30;
  CHECK(s.share() == 1);
  CHECK(s.a.volume.num_chunks() == 0);
  CHECK(s.at(s.b, {-8, 5, 0}) == -30);
}

TEST_CASE("a floor that both show takes no wall along that only one of them has") {
  TwoSubmaps s;
  s.add_wall(s.a, {5, 0, 0}, 1);
  s.add_wall(s.b, {5, 0, 0}, 1);
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.a.volume.make_place(s.pools, {5, 0, 0}, &chunk);
  Block* block = s.a.volume.make_block(s.pools, *chunk, *place);
  for (int i = 0; i < kBlockVoxels; ++i) {
    if ((i >> 3 & 7) >= 6) block->voxels[i] = 30;
  }
  CHECK(s.share(Pose::Identity(), SharingTrust::kUncertain) == 0);
  CHECK(s.a.volume.num_blocks() == 1);
}

/// A sliver of a wall in a, which is nearer but knows less than half of the place, so that nothing is given either way; and
/// what b has there.
struct Sliver : TwoSubmaps {
  explicit Sliver(int rows) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = a.volume.make_place(pools, {-2, 0, 0}, &chunk);
    Block* block = a.volume.make_block(pools, *chunk, *place);
    for (int row = 0; row < rows; ++row) {
      block->voxels[kBlockEdge * row] = 30;
      block->voxels[kBlockEdge * row + 1] = -30;
    }
  }
  [[nodiscard]] bool is_left() const { return at(a, {-2, 0, 0}) == 30; }
  [[nodiscard]] bool is_free_before() const {
    return a.volume.at(store, VoxelCoord(-2 * kBlockEdge + 1, 0, 0)) == -30;
  }
};

TEST_CASE("of a wall that another grid cuts differently a sliver goes where the other shows it, and what is free stays") {
  const auto left_of_sliver = [](int rows, int aside_vox, SharingTrust trust) {
    Sliver s(rows);
    s.add_wall(s.b, {-2, 0, 0}, 1);
    const auto moved = s.share(aside(aside_vox), trust);
    CHECK(s.is_free_before());
    CHECK(s.at(s.b, {-2, 0, 0}) == 30);
    CHECK(moved == (s.is_left() ? 0u : 1u));
    return s.is_left();
  };
  CHECK_FALSE(left_of_sliver(40, 0, SharingTrust::kFull));
  CHECK_FALSE(left_of_sliver(40, 2, SharingTrust::kFull));
  CHECK(left_of_sliver(40, 3, SharingTrust::kFull));
  CHECK(left_of_sliver(48, 0, SharingTrust::kFull));
  CHECK(left_of_sliver(40, 0, SharingTrust::kUncertain));
}

TEST_CASE("a wall's other side, and one that nothing is known before, show no sliver of it") {
  for (const bool is_free_behind : {false, true}) {
    Sliver s(20);
    Chunk* chunk = nullptr;
    std::uint32_t* place = s.b.volume.make_place(s.pools, {-2, 0, 0}, &chunk);
    Block* block = s.b.volume.make_block(s.pools, *chunk, *place);
    for (int row = 0; row < 64; ++row) block->voxels[kBlockEdge * row] = 30;
    for (int row = 0; row < 32; ++row) block->voxels[kBlockEdge * row + 7] = 30;
    if (is_free_behind) s.add_free(s.b, {-3, 0, 0});
    CHECK(s.share() == 0);
    CHECK(s.is_left());
  }
}

TEST_CASE("a sliver stays where its octant would come out free without it") {
  Sliver s(40);
  s.add_wall(s.b, {-2, 0, 0}, 1);
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.a.volume.make_place(s.pools, {-2, 0, 0}, &chunk);
  Block* block = s.a.volume.make_block(s.pools, *chunk, *place);
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (octant_of(i) == 0 && block->voxels[i] == kUnknownLogOdds) block->voxels[i] = -30;
  }
  CHECK(s.share() == 0);
  CHECK(s.is_left());
}

TEST_CASE("of two slivers that show each other, one stays") {
  Sliver s(40);
  Chunk* chunk = nullptr;
  std::uint32_t* place = s.b.volume.make_place(s.pools, {-2, 0, 0}, &chunk);
  Block* block = s.b.volume.make_block(s.pools, *chunk, *place);
  for (int row = 0; row < 40; ++row) block->voxels[kBlockEdge * row] = 30;
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (i % kBlockEdge > 0 && i < 3 * 64) block->voxels[i] = -30;
  }
  (void)s.share();
  CHECK((s.is_left() || s.at(s.b, {-2, 0, 0}) == 30));
}

TEST_CASE("chunks in which nothing is known any more go back to the pool") {
  TwoSubmaps s;
  for (int x = 8; x < 16; ++x) {
    s.add_wall(s.a, {x, 0, 0});
    s.add_wall(s.b, {x, 0, 0});
  }
  REQUIRE(s.a.volume.num_chunks() == 1);
  CHECK(s.share() == 8);
  CHECK(s.a.volume.num_chunks() == 0);
  CHECK(s.a.volume.num_blocks() == 0);
  CHECK(s.pools.chunks.num_free() == s.store.num_chunks() - 1);
}

TEST_CASE(
    "between rotated grids a shared wall is known to one submap only, and none of it is lost") {
  TwoSubmaps s;
  const Pose T_a_b(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  for (int x = -10; x < 10; ++x) {
    for (int y = -1; y < 2; ++y) {
      s.add_wall(s.a, {x, y, 0});
      s.add_wall(s.b, {x, y, 0});
    }
  }
  const auto moved = s.share(T_a_b);
  REQUIRE(moved.has_value());
  CHECK(*moved >= 50);
  int num_lost = 0;
  for (int x = -9 * kBlockEdge; x < 9 * kBlockEdge; ++x) {
    const Eigen::Vector3d p_a = (Eigen::Vector3d(x, 4, 4).array() + 0.5) * s.config.voxel_size_m;
    const Eigen::Vector3d p_b = T_a_b.inverse() * p_a / s.config.voxel_size_m;
    const bool in_a = s.a.volume.at(s.store, {x, 4, 4}) != kUnknownLogOdds;
    const bool in_b =
        s.b.volume.at(s.store, p_b.array().floor().matrix().cast<int>()) != kUnknownLogOdds;
    num_lost += !in_a && !in_b;
  }
  CHECK(num_lost == 0);
}

TEST_CASE("when the pools are too small for the giving, both submaps stay as they were") {
  TwoSubmaps s(30);
  const Pose T_a_b(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  for (int x = 1; x < 16; ++x) {
    s.add_wall(s.a, {x, 2, 0});
    s.add_wall(s.b, {x, 2, 0});
  }
  REQUIRE(s.pools.blocks.num_free() == 0);
  CHECK_FALSE(s.share(T_a_b).has_value());
  for (int x = 1; x < 16; ++x) {
    CHECK(s.at(s.a, {x, 2, 0}) == 30);
    CHECK(s.at(s.b, {x, 2, 0}) == 30);
  }
}

}  // namespace
}  // namespace cloister
