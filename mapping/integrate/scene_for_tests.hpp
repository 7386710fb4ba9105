#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <unordered_set>
#include <vector>

#include <doctest/doctest.h>

#include "mapping/integrate/scan_integrator.hpp"
#include "mapping/scan/spinning_sensor_for_tests.hpp"

namespace cloister {

/// Solid boxes along the axes and upright cylinders, to be seen by beams.
struct Scene {
  struct Box {
    Eigen::Vector3f low, high;
  };
  struct Cylinder {
    Eigen::Vector2f middle;
    float radius, low_z, high_z;
  };
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;

  /// Walls, floor and ceiling, 0.2 m thick, around a space.
  void add_room(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool is_high : {false, true}) {
        Box wall{low - Eigen::Vector3f::Constant(0.2f), high + Eigen::Vector3f::Constant(0.2f)};
        (is_high ? wall.low : wall.high)[axis] = (is_high ? high : low)[axis];
        boxes.push_back(wall);
      }
    }
  }

  /// Distance to the first surface along a beam; infinity when there is none.
  [[nodiscard]] float cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
    float nearest = std::numeric_limits<float>::infinity();
    const Eigen::Array3f per_direction = direction.array().inverse();
    for (const Box& box : boxes) {
      const Eigen::Array3f one = (box.low - origin).array() * per_direction;
      const Eigen::Array3f other = (box.high - origin).array() * per_direction;
      const float enter = one.min(other).maxCoeff(), leave = one.max(other).minCoeff();
      if (enter > 0 && enter <= leave) nearest = std::min(nearest, enter);
    }
    for (const Cylinder& cylinder : cylinders) {
      const Eigen::Vector2f to = origin.head<2>() - cylinder.middle, along = direction.head<2>();
      const float a = along.squaredNorm(), b = to.dot(along),
                  c = to.squaredNorm() - cylinder.radius * cylinder.radius;
      const float enter = (-b - std::sqrt(std::max(b * b - a * c, 0.0f))) / a;
      const float z = origin.z() + enter * direction.z();
      if (b * b > a * c && enter > 0 && z > cylinder.low_z && z < cylinder.high_z)
        nearest = std::min(nearest, enter);
      const float to_top = (cylinder.high_z - origin.z()) / direction.z();
      if (to_top > 0 && (to + to_top * along).norm() < cylinder.radius)
        nearest = std::min(nearest, to_top);
    }
    return nearest;
  }
};

/// Where the sensor is, by seconds since a scan began.
using Motion = std::function<Pose(double)>;

inline Pose upright_pose(double x, double y, double z, double yaw_rad = 0) {
  Pose T(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}
inline Motion standing(const Pose& T_S_L) {
  return [T_S_L](double) { return T_S_L; };
}

/// One revolution in a tenth of a second, ranges rounded to millimetres.
inline Scan see(const Scene& scene, const ScanGeometry& geometry, const Motion& motion) {
  constexpr std::int64_t kRevolutionNs = 100'000'000;
  Scan scan;
  scan.geometry = &geometry;
  scan.ranges_mm.assign(geometry.direction_L.size(), 0);
  scan.column_valid.assign(geometry.num_columns, 1);
  for (int column = 0; column < geometry.num_columns; ++column) {
    scan.column_stamps.push_back({kRevolutionNs * column / geometry.num_columns});
    const Pose T_S_L = motion(1e-9 * static_cast<double>(scan.column_stamps.back().ns));
    const Eigen::Matrix3f R_S_L = T_S_L.linear().cast<float>();
    const Eigen::Vector3f t_S_L = T_S_L.translation().cast<float>();
    for (int beam = 0; beam < geometry.num_beams; ++beam) {
      const std::size_t pixel = static_cast<std::size_t>(beam) * geometry.num_columns + column;
      const float range_m =
          scene.cast(R_S_L * geometry.origin_L[pixel] + t_S_L, R_S_L * geometry.direction_L[pixel]);
      if (range_m < 120)
        scan.ranges_mm[pixel] = static_cast<std::uint32_t>(std::lround(1000 * range_m));
    }
  }
  scan.stamp = scan.column_stamps.back();
  for (std::int64_t ns = 0; ns <= kRevolutionNs; ns += 10'000'000) {
    scan.poses.push_back({{ns}, motion(1e-9 * static_cast<double>(ns))});
  }
  return scan;
}

inline VoxelCoord voxel_at(const Eigen::Vector3f& p_S, double voxel_size_m) {
  return (p_S * static_cast<float>(1 / voxel_size_m)).array().floor().cast<int>();
}

/// A set of voxels within 2^20 of the origin.
class VoxelSet {
 public:
  void insert(const VoxelCoord& v) { keys_.insert(key_of(v)); }
  [[nodiscard]] bool contains(const VoxelCoord& v) const { return keys_.contains(key_of(v)); }
  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  template <typename Visitor>
  void for_each(Visitor&& visit) const {
    for (const std::uint64_t key : keys_) {
      const auto part = [&](int shift) {
        return static_cast<int>(key >> shift & 0x1fffff) - (1 << 20);
      };
      visit(VoxelCoord(part(0), part(21), part(42)));
    }
  }

 private:
  static std::uint64_t key_of(const VoxelCoord& v) {
    const auto part = [](int c) { return static_cast<std::uint64_t>(c + (1 << 20)); };
    return part(v.x()) | part(v.y()) << 21 | part(v.z()) << 42;
  }
  std::unordered_set<std::uint64_t> keys_;
};

/// A volume that scans are integrated into.
struct SceneMap {
  explicit SceneMap(const ScanGeometry& geometry, const VoxelConfig& voxel_config = {},
                    std::size_t blocks = 60'000, std::size_t chunks = 4'000,
                    ScanWorkers* workers = nullptr)
      : config(voxel_config),
        store(blocks, chunks),
        pools(store),
        integrator(config, workers),
        beams(geometry.direction_L.size()) {
    pools.take_all();
  }

  IntegrationResult integrate(const Scan& scan) {
    REQUIRE(beams.assign(scan, Pose::Identity(), config) == 0);
    REQUIRE(beams.is_image());
    const Eigen::Vector3f sensor_S =
        scan.poses[scan.poses.size() / 2].T_R_L.translation().cast<float>();
    return integrator.integrate(beams, sensor_S, pools, volume);
  }
  [[nodiscard]] VoxelCoord voxel_of(const Eigen::Vector3f& p_S) const {
    return voxel_at(p_S, config.voxel_size_m);
  }
  [[nodiscard]] Eigen::Vector3f centre_of(const VoxelCoord& voxel) const {
    return (voxel.cast<float>().array() + 0.5f) * static_cast<float>(config.voxel_size_m);
  }
  [[nodiscard]] LogOdds at(const Eigen::Vector3f& p_S) const {
    return volume.at(store, voxel_of(p_S));
  }
  /// Adds the voxels of the last scan's returns that lie in a box.
  void add_hit_voxels(const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                      VoxelSet& voxels) const {
    for (std::size_t i = 0; i < beams.num_returns(); ++i) {
      const Eigen::Vector3f p_S = beams.return_S(i);
      if ((p_S.array() < low.array()).any() || (p_S.array() > high.array()).any()) continue;
      voxels.insert(voxel_of(p_S));
    }
  }
  /// Which share of the voxels is occupied, or the one behind each. A surface is marked the further behind its returns the
  /// more squarely it is met: near the border of two layers it may move into the one behind.
  /// @param behind  from a voxel to the one behind it
  [[nodiscard]] double share_standing(const VoxelSet& voxels, const VoxelCoord& behind) const {
    std::size_t count = 0;
    voxels.for_each([&](const VoxelCoord& v) {
      count += volume.at(store, v) > 0 || volume.at(store, v + behind) > 0;
    });
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::size_t>(voxels.size(), 1));
  }
  /// Which share of the voxels is in a state.
  [[nodiscard]] double share(const VoxelSet& voxels, VoxelState state) const {
    std::size_t count = 0;
    voxels.for_each([&](const VoxelCoord& v) { count += state_of(volume.at(store, v)) == state; });
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::size_t>(voxels.size(), 1));
  }
  /// Which share of the layers that the voxels lie in has one that is occupied.
  [[nodiscard]] double share_of_layers(const VoxelSet& voxels) const {
    std::map<int, bool> layers;
    voxels.for_each([&](const VoxelCoord& v) { layers[v.z()] |= volume.at(store, v) > 0; });
    std::size_t count = 0;
    for (const auto& [z, is_occupied] : layers) count += is_occupied;
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::size_t>(layers.size(), 1));
  }
  /// Voxels whose centres lie in a box.
  [[nodiscard]] VoxelSet voxels_in(const Eigen::Vector3f& low, const Eigen::Vector3f& high) const {
    VoxelSet voxels;
    const VoxelCoord first = voxel_of(low), last = voxel_of(high);
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) {
          const Eigen::Vector3f c = centre_of({x, y, z});
          if ((c.array() >= low.array()).all() && (c.array() <= high.array()).all())
            voxels.insert({x, y, z});
        }
      }
    }
    return voxels;
  }

  VoxelConfig config;
  VoxelStore store;
  VoxelPools pools;
  ScanIntegrator integrator;
  ScanBeams beams;
  Volume volume;
};

}  // namespace cloister
