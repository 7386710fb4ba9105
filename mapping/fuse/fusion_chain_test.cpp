#include <array>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/fuse/fuser.hpp"
#include "mapping/integrate/scan_integrator.hpp"
#include "mapping/scan/scan.hpp"
#include "mapping/scan/scan_beams.hpp"

namespace cloister {
namespace {

/// The inside of a furnished room as a sensor at `p` measures it, with range noise, in M.
std::vector<Eigen::Vector3f> look_around(const Eigen::Vector3f& p, std::mt19937& random) {
  const Eigen::AlignedBox3f room(Eigen::Vector3f(-4, -3.2f, 0), Eigen::Vector3f(4, 3.2f, 2.5f));
  const std::array<Eigen::AlignedBox3f, 2> furniture = {
      Eigen::AlignedBox3f(Eigen::Vector3f(2.5f, -3.2f, 0), Eigen::Vector3f(4, -2.3f, 0.8f)),
      Eigen::AlignedBox3f(Eigen::Vector3f(-4, 2, 0), Eigen::Vector3f(-3.5f, 3.2f, 2.0f))};
  std::normal_distribution<float> noise_m(0, 0.01f);
  std::vector<Eigen::Vector3f> points;
  for (int column = 0; column < 300; ++column) {
    for (int row = 0; row < 48; ++row) {
      const float azimuth = 6.2832f * static_cast<float>(column) / 300;
      const float elevation = 0.8f * (static_cast<float>(row) / 23.5f - 1);
      const Eigen::Vector3f d(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Array3f to_low = (room.min() - p).array() / d.array();
      const Eigen::Array3f to_high = (room.max() - p).array() / d.array();
      float range_m = to_low.max(to_high).minCoeff();
      for (const Eigen::AlignedBox3f& box : furniture) {
        const Eigen::Array3f low = (box.min() - p).array() / d.array();
        const Eigen::Array3f high = (box.max() - p).array() / d.array();
        const float enter_m = low.min(high).maxCoeff();
        if (enter_m > 0 && enter_m < low.max(high).minCoeff()) range_m = std::min(range_m, enter_m);
      }
      points.push_back((range_m + noise_m(random)) * d);
    }
  }
  return points;
}

TEST_CASE(
    "ten fusions in a row cost less than one per cent of what a volume integrated in one piece "
    "says") {
  constexpr int kSubmaps = 11;
  constexpr int kScansEach = 6;
  const VoxelConfig config;
  VoxelStore store(60'000, 2'000);
  VoxelPools pools(store);
  pools.take_all();
  ScanIntegrator integrator(config);
  ScanBeams beams(20'000);
  std::array<Volume, kSubmaps> volumes;
  std::array<Pose, kSubmaps> T_M_S;
  Volume whole;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift_m(-0.2, 0.2), angle_rad(-0.015, 0.015),
      place_m(-1.2, 1.2);
  for (int n = 0; n < kSubmaps; ++n) {
    // Corrections have moved every later submap off the first one's grid.
    T_M_S[n] = Pose::Identity();
    if (n > 0) {
      T_M_S[n] = Pose(Eigen::Translation3d(shift_m(random), shift_m(random), shift_m(random)) *
                      Eigen::AngleAxisd(angle_rad(random), Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(0.2 * angle_rad(random), Eigen::Vector3d::UnitX()));
    }
    for (int k = 0; k < kScansEach; ++k) {
      Pose T_M_L = Pose::Identity();
      T_M_L.translation() = Eigen::Vector3d(place_m(random), place_m(random), 1.1);
      Scan scan;
      scan.kind = Scan::Kind::kCloud;
      scan.points_L = look_around(T_M_L.translation().cast<float>(), random);
      scan.poses = {{scan.stamp, T_M_L}};
      for (const auto& [T_S_M, volume] :
           {std::pair{Pose(T_M_S[n].inverse()), &volumes[n]}, {Pose::Identity(), &whole}}) {
        (void)beams.assign(scan, T_S_M, config);
        (void)integrator.integrate(beams, (T_S_M * T_M_L).translation().cast<float>(), pools,
                                   *volume);
      }
    }
  }
  for (int n = 1; n < kSubmaps; ++n) {
    REQUIRE(fuse_volume(volumes[n], T_M_S[n].inverse() * T_M_S[0], config, pools, volumes[0]));
  }
  std::int64_t num_known = 0, num_agreeing = 0;
  for (int z = -4; z < 44; ++z) {
    for (int y = -56; y < 56; ++y) {
      for (int x = -68; x < 68; ++x) {
        const VoxelState in_whole = state_of(whole.at(store, {x, y, z}));
        const VoxelState in_fused = state_of(volumes[0].at(store, {x, y, z}));
        if (in_whole == VoxelState::kUnknown || in_fused == VoxelState::kUnknown) continue;
        ++num_known;
        num_agreeing += in_whole == in_fused;
      }
    }
  }
  const double agreement = static_cast<double>(num_agreeing) / static_cast<double>(num_known);
  CAPTURE(num_known);
  CAPTURE(agreement);
  CHECK(num_known > 200'000);
  CHECK(agreement > 0.99);
}

}  // namespace
}  // namespace cloister
