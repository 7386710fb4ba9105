#include "mapping/overlap/hull_query.hpp"

#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/overlap/separating_axes_for_tests.hpp"

namespace cloister {
namespace {

constexpr double kVoxel = 0.1;
constexpr LogOdds kLowest = -40, kHighest = 70;
using Eigen::Vector3d;

/// A map whose voxels are set one by one.
struct TestMap {
  VoxelStore store{4096, 256};
  VoxelPools pools{store};
  std::vector<Submap> submaps;

  explicit TestMap(std::size_t num_submaps) : submaps(num_submaps) {
    pools.take_all();
    for (std::size_t i = 0; i < num_submaps; ++i) submaps[i].id = static_cast<SubmapId>(i);
  }
  void set(std::size_t submap, const VoxelCoord& voxel, LogOdds value) {
    Chunk* chunk = nullptr;
    Volume& volume = submaps[submap].volume;
    std::uint32_t* place = volume.make_place(pools, parent_coord(voxel), &chunk);
    volume.make_block(pools, *chunk, *place)->voxels[index_in_block(voxel)] = value;
  }
  void set_block(std::size_t submap, const BlockCoord& block, LogOdds value, OctantMask known) {
    Chunk* chunk = nullptr;
    Volume& volume = submaps[submap].volume;
    std::uint32_t* place = volume.make_place(pools, block, &chunk);
    volume.set_coarse(pools, *chunk, *place, value, known);
  }
  /// A cube of 4 x 4 x 4 blocks around the origin, all free.
  void clear(std::size_t submap) {
    for (int z = -2; z < 2; ++z) {
      for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) set_block(submap, {x, y, z}, -20, kAllOctants);
      }
    }
  }
  [[nodiscard]] std::vector<const Submap*> all() const {
    std::vector<const Submap*> all;
    for (const Submap& submap : submaps) all.push_back(&submap);
    return all;
  }
  [[nodiscard]] HullQuery query() const { return {store, kVoxel, kLowest, kHighest, all()}; }

  [[nodiscard]] VoxelState combined(const Vector3d& p_M) const {
    EvidenceSum evidence;
    for (const Submap& submap : submaps) {
      const Vector3d p_S = submap.T_M_S.inverse() * p_M;
      evidence.add(submap.volume.at(store, (p_S / kVoxel).array().floor().cast<int>()), submap.id);
    }
    return evidence.answer(kLowest, kHighest).state;
  }
};

std::vector<Vector3d> corners_of(const OrientedBox& box) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corners.push_back(box.centre_M + box.R_M_S * sign.cwiseProduct(box.half_extents_m));
  }
  return corners;
}

/// Every voxel of every grid near the box, by the separating-axis theorem.
VoxelState brute_force(const TestMap& map, const OrientedBox& body) {
  const Eigen::AlignedBox3d bounds_M = bounds_in_map(body);
  const auto visit = [&](const Pose& T_M_G, auto&& decide) {
    const Vector3d centre_G = T_M_G.inverse() * bounds_M.center();
    const int reach = static_cast<int>(bounds_M.sizes().norm() / kVoxel) / 2 + 3;
    const VoxelCoord middle = (centre_G / kVoxel).array().floor().cast<int>();
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const VoxelCoord voxel = middle + VoxelCoord(x, y, z);
          const Vector3d p_M = T_M_G * Vector3d((voxel.cast<double>().array() + 0.5) * kVoxel);
          const OrientedBox cell{p_M, Vector3d::Constant(0.5 * kVoxel), T_M_G.linear()};
          if (decide(voxel, p_M) && separating_axis_gap_m(cell, body) <= 0) return true;
        }
      }
    }
    return false;
  };
  for (const Submap& submap : map.submaps) {
    const bool is_occupied = visit(submap.T_M_S, [&](const VoxelCoord& voxel, const Vector3d& p_M) {
      return submap.volume.at(map.store, voxel) > 0 && map.combined(p_M) == VoxelState::kOccupied;
    });
    if (is_occupied) return VoxelState::kOccupied;
  }
  const bool is_unknown = visit(Pose::Identity(), [&](const VoxelCoord&, const Vector3d& p_M) {
    return map.combined(p_M) == VoxelState::kUnknown;
  });
  return is_unknown ? VoxelState::kUnknown : VoxelState::kFree;
}

TEST_CASE(
    "a body gets the answer of all voxels it touches, whatever the poses of body and submaps") {
  constexpr unsigned kSeed = 7;
  CAPTURE(kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double size) {
    return Vector3d(size * uniform(random), size * uniform(random), size * uniform(random));
  };
  const auto rotation = [&](double size) {
    return Eigen::AngleAxisd(size * uniform(random), vector(1).normalized()).toRotationMatrix();
  };
  int count[3] = {};
  for (int round = 0; round < 18; ++round) {
    TestMap map(3);
    for (std::size_t i = 0; i < 3; ++i) {
      map.submaps[i].T_M_S = make_pose(vector(0.2), Eigen::Quaterniond(rotation(0.3)));
      map.clear(i);
      std::uniform_int_distribution<int> coordinate(-16, 15);
      for (int k = 0; k < 100; ++k) {
        map.set(i, {coordinate(random), coordinate(random), coordinate(random)},
                static_cast<LogOdds>(110 * uniform(random)));
      }
      // Holes: the same in all submaps, or others would know what is in them.
      for (const BlockCoord& hole : {BlockCoord(1, 1, 1), BlockCoord(-2, -2, 0)}) {
        map.set_block(i, hole, -20, round % 2 == 0 ? 0x0f : kNoOctants);
      }
    }
    HullQuery query = map.query();
    for (int k = 0; k < 12; ++k) {
      OrientedBox body;
      body.centre_M = vector(1.8);
      body.half_extents_m = vector(0.25).cwiseAbs();
      body.R_M_S = rotation(3);
      const auto answer = query.at(corners_of(body));
      REQUIRE(answer);
      CAPTURE(round);
      CAPTURE(k);
      CHECK(answer->state == brute_force(map, body));
      ++count[static_cast<int>(answer->state)];
    }
  }
  for (const int times : count) CHECK(times > 10);
}

TEST_CASE("what one submap has seen free, others may hold occupied: the evidence decides") {
  TestMap map(2);
  for (std::size_t i = 0; i < 2; ++i) map.clear(i);
  const std::vector<Vector3d> body = {{0.01, 0.01, 0.01}, {0.09, 0.01, 0.01}, {0.01, 0.09, 0.09}};
  CHECK(map.query().at(body)->state == VoxelState::kFree);
  map.set(0, {0, 0, 0}, 15);
  CHECK(map.query().at(body)->state == VoxelState::kFree);
  map.set(0, {0, 0, 0}, 25);
  const auto answer = map.query().at(body);
  CHECK(answer->state == VoxelState::kOccupied);
  CHECK(answer->submap == 0);
  CHECK(answer->where_M.isApprox(Vector3d::Constant(0.05)));
}

TEST_CASE("a body that touches a voxel's face, or is a single point, is not missed") {
  TestMap map(1);
  map.clear(0);
  map.set(0, {3, 0, 0}, 50);
  CHECK(map.query().at(std::vector<Vector3d>{{0.1, 0.05, 0.05}, {0.3, 0.05, 0.05}})->state ==
        VoxelState::kOccupied);
  CHECK(map.query().at(std::vector<Vector3d>{{0.1, 0.05, 0.05}, {0.29, 0.05, 0.05}})->state ==
        VoxelState::kFree);
  CHECK(map.query().at(std::vector<Vector3d>{{0.35, 0.05, 0.05}})->state == VoxelState::kOccupied);
  CHECK(map.query().at(std::vector<Vector3d>{{50, 0, 0}})->state == VoxelState::kUnknown);
}

TEST_CASE("an empty map knows nothing, and what is no body gets no answer") {
  TestMap map(0);
  HullQuery query = map.query();
  CHECK(query.at(std::vector<Vector3d>{{0, 0, 0}})->state == VoxelState::kUnknown);
  CHECK_FALSE(query.at({}));
  CHECK_FALSE(query.at(std::vector<Vector3d>(HullQuery::kMaxCorners + 1, Vector3d::Zero())));
  CHECK_FALSE(query.at(std::vector<Vector3d>{{0, 0, std::numeric_limits<double>::quiet_NaN()}}));
  CHECK_FALSE(query.at(std::vector<Vector3d>{{0, 0, 0}, {100, 100, 100}}));
}

}  // namespace
}  // namespace cloister
