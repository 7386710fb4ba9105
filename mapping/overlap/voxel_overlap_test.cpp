#include "mapping/overlap/voxel_overlap.hpp"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

namespace cloister {
namespace {

constexpr double kVoxel = 0.065;

struct TwoVolumes {
  TwoVolumes() : store(16384, 256), pools(store) { pools.take_all(); }
  void set(Volume& volume, const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(voxel)] = value;
  }
  void set_block(Volume& volume, const BlockCoord& block, LogOdds value, OctantMask known) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, block, &chunk);
    volume.set_coarse(pools, *chunk, *place, value, known);
  }
  /// Random voxels and coarse nodes, whole and partly known ones, in a cube of 40 voxels around the origin.
  void fill(Volume& volume, unsigned seed) {
    std::mt19937 rng(seed);
    std::uniform_int_distribution<int> coordinate(-20, 19), block(-3, 2), value(-40, 70);
    for (int i = 0; i < 40; ++i) {
      const auto known = i % 2 ? static_cast<OctantMask>(1 + rng() % 255) : kAllOctants;
      set_block(volume, {block(rng), block(rng), block(rng)}, -20, known);
    }
    for (int i = 0; i < 10'000; ++i) {
      set(volume, {coordinate(rng), coordinate(rng), coordinate(rng)},
          static_cast<LogOdds>(value(rng)));
    }
  }
  VoxelStore store;
  VoxelPools pools;
  Volume a, b;
};

/// The slow, obvious version: every voxel of a cube around the origin by itself.
VoxelOverlap brute_force(const TwoVolumes& v, const Pose& T_b_a) {
  VoxelOverlap overlap;
  for (int z = -80; z < 80; ++z) {
    for (int y = -80; y < 80; ++y) {
      for (int x = -80; x < 80; ++x) {
        const LogOdds value_a = v.a.at(v.store, {x, y, z});
        overlap.num_known_a += value_a != 0;
        overlap.num_known_b += v.b.at(v.store, {x, y, z}) != 0;
        if (value_a == 0) continue;
        const Eigen::Vector3d p_b =
            T_b_a * (Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kVoxel) / kVoxel;
        const VoxelCoord voxel_b(static_cast<int>(std::floor(p_b.x())),
                                 static_cast<int>(std::floor(p_b.y())),
                                 static_cast<int>(std::floor(p_b.z())));
        overlap.num_agreeing += state_of(v.b.at(v.store, voxel_b)) == state_of(value_a);
      }
    }
  }
  return overlap;
}

TEST_CASE("a volume overlaps itself entirely") {
  TwoVolumes v;
  v.fill(v.a, 1);
  v.fill(v.b, 1);
  const VoxelOverlap overlap = voxel_overlap(v.store, v.a, v.b, Pose::Identity(), kVoxel);
  CHECK(overlap.ratio_a() == 1.0);
  CHECK(overlap.ratio_b() == 1.0);
}

TEST_CASE("on grids that agree the overlap equals that of a voxel by voxel count") {
  TwoVolumes v;
  v.fill(v.a, 1);
  v.fill(v.b, 2);
  for (const Eigen::Vector3d& shift :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(8, -16, 0), Eigen::Vector3d(3, 1, -5)}) {
    Pose T_b_a = Pose::Identity();
    T_b_a.translation() = shift * kVoxel;
    const VoxelOverlap fast = voxel_overlap(v.store, v.a, v.b, T_b_a, kVoxel);
    const VoxelOverlap slow = brute_force(v, T_b_a);
    CHECK(fast.num_agreeing == slow.num_agreeing);
    CHECK(fast.num_known_a == slow.num_known_a);
    CHECK(fast.num_known_b == slow.num_known_b);
  }
}

TEST_CASE("partly known coarse nodes overlap as the same voxels one by one do") {
  TwoVolumes coarse, plain;
  std::mt19937 rng(6);
  for (int i = 0; i < 200; ++i) {
    const BlockCoord coord(i % 6 - 3, i / 6 % 6 - 3, i / 36 - 3);
    for (const bool is_a : {true, false}) {
      const auto known = static_cast<OctantMask>(rng() % 256);
      coarse.set_block(is_a ? coarse.a : coarse.b, coord, -8, known);
      Volume& volume = is_a ? plain.a : plain.b;
      for (int v = 0; v < kBlockVoxels; ++v) {
        const VoxelCoord voxel = coord * kBlockEdge + VoxelCoord(v & 7, v >> 3 & 7, v >> 6);
        if ((known >> octant_of(v) & 1) != 0) plain.set(volume, voxel, -8);
      }
    }
  }
  for (const double angle : {0.0, 0.4}) {
    Pose T_b_a(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.2, -0.3, 0.9).normalized()));
    const VoxelOverlap one = voxel_overlap(coarse.store, coarse.a, coarse.b, T_b_a, kVoxel);
    const VoxelOverlap other = voxel_overlap(plain.store, plain.a, plain.b, T_b_a, kVoxel);
    CHECK(one.num_agreeing == other.num_agreeing);
    CHECK(one.num_known_a == other.num_known_a);
    CHECK(one.num_known_b == other.num_known_b);
    CHECK(one.num_agreeing > 10'000);
  }
}

TEST_CASE(
    "between rotated grids the overlap equals that of a voxel by voxel count, but for rounding") {
  TwoVolumes v;
  v.fill(v.a, 3);
  v.fill(v.b, 4);
  for (const double angle : {0.01, 0.4, 1.2, -2.6}) {
    Pose T_b_a(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.2, -0.3, 0.9).normalized()));
    T_b_a.translation() = Eigen::Vector3d(0.123, -0.05, 0.31);
    const VoxelOverlap fast = voxel_overlap(v.store, v.a, v.b, T_b_a, kVoxel);
    const VoxelOverlap slow = brute_force(v, T_b_a);
    CHECK(std::abs(fast.num_agreeing - slow.num_agreeing) <= 3);
  }
}

TEST_CASE("far from the submap's origin the overlap is that of the same voxels near it") {
  TwoVolumes near, far;
  const VoxelCoord offset(64 << 14, 64 << 10, -64 << 12);
  std::mt19937 rng(5);
  std::uniform_int_distribution<int> coordinate(-20, 19), value(-40, 70);
  for (int i = 0; i < 10'000; ++i) {
    const VoxelCoord voxel(coordinate(rng), coordinate(rng), coordinate(rng));
    const auto log_odds = static_cast<LogOdds>(value(rng));
    near.set(i % 2 ? near.a : near.b, voxel, log_odds);
    far.set(i % 2 ? far.a : far.b, voxel + offset, log_odds);
  }
  const Pose T_turn(Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, -0.3, 0.9).normalized()));
  const Eigen::Translation3d to_far(offset.cast<double>() * kVoxel);
  const Pose T_b_a(to_far * T_turn * to_far.inverse());
  const VoxelOverlap here = voxel_overlap(near.store, near.a, near.b, T_turn, kVoxel);
  const VoxelOverlap there = voxel_overlap(far.store, far.a, far.b, T_b_a, kVoxel);
  CHECK(here.num_agreeing > 100);
  CHECK(std::abs(here.num_agreeing - there.num_agreeing) <= 3);
}

TEST_CASE("of large volumes a sample tells the overlap to a few thousandths") {
  // A hall with walls along all axes, and the same with another wall at a slant, half of it unknown.
  TwoVolumes v;
  const auto fill = [&](Volume& volume, bool is_other) {
    for (int z = -6; z < 6; ++z) {
      for (int y = -10; y < 10; ++y) {
        for (int x = -10; x < 10; ++x) {
          const BlockCoord block(x, y, z);
          if (is_other && x > 2 && y > 0) continue;
          if (z == 2 || (z == 3 && is_other)) {
            v.set_block(volume, block, -8, x % 3 == 0 ? OctantMask{0x0f} : kAllOctants);
            continue;
          }
          for (int i = 0; i < kBlockVoxels; ++i) {
            const VoxelCoord voxel = block * kBlockEdge + VoxelCoord(i & 7, i >> 3 & 7, i >> 6);
            const bool is_wall = voxel.x() % 16 == 5 || voxel.y() % 16 == 0 || voxel.z() % 16 == 3;
            const bool is_slanted = is_other && (voxel.x() + 2 * voxel.z()) % 24 == 0;
            if (voxel.z() % 16 == 4 && !is_other) continue;
            v.set(volume, voxel, is_wall || is_slanted ? LogOdds{40} : LogOdds{-20});
          }
        }
      }
    }
  };
  fill(v.a, false);
  fill(v.b, true);
  for (const double angle : {0.0, 0.02, 0.7}) {
    Pose T_b_a(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.2, -0.3, 0.9).normalized()));
    T_b_a.translation() = Eigen::Vector3d(0.2, -0.05, 0.01);
    const VoxelOverlap sampled = voxel_overlap(v.store, v.a, v.b, T_b_a, kVoxel);
    const VoxelOverlap slow = brute_force(v, T_b_a);
    CHECK(slow.num_known_a > 1'500'000);
    CHECK(static_cast<double>(sampled.num_known_a) ==
          doctest::Approx(static_cast<double>(slow.num_known_a)).epsilon(0.003));
    CHECK(static_cast<double>(sampled.num_known_b) ==
          doctest::Approx(static_cast<double>(slow.num_known_b)).epsilon(0.003));
    CHECK(slow.ratio_a() > 0.3);
    CHECK(sampled.ratio_a() == doctest::Approx(slow.ratio_a()).epsilon(0.005));
    CHECK(sampled.ratio_b() == doctest::Approx(slow.ratio_b()).epsilon(0.005));
  }
}

TEST_CASE("an empty volume overlaps nothing") {
  TwoVolumes v;
  v.fill(v.a, 1);
  const VoxelOverlap overlap = voxel_overlap(v.store, v.a, v.b, Pose::Identity(), kVoxel);
  CHECK(overlap.ratio_a() == 0);
  CHECK(overlap.ratio_b() == 0);
  CHECK(known_bounds(v.store, v.b, kVoxel).isEmpty());
}

TEST_CASE("the bounds of a volume hold every known voxel and whole blocks only") {
  TwoVolumes v;
  v.set(v.a, {-1, 0, 17}, 5);
  v.set(v.a, {9, 3, 2}, -5);
  const Eigen::AlignedBox3d bounds = known_bounds(v.store, v.a, kVoxel);
  CHECK((bounds.min() / kVoxel - Eigen::Vector3d(-8, 0, 0)).norm() < 1e-9);
  CHECK((bounds.max() / kVoxel - Eigen::Vector3d(16, 8, 24)).norm() < 1e-9);
}

}  // namespace
}  // namespace cloister
