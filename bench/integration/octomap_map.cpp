#include "bench/integration/octomap_map.hpp"

#include <cmath>

// OctoMap would otherwise tell about its progress on stderr.
#define OCTOMAP_NODEBUGOUT
#include <octomap/OcTree.h>

namespace cloister {

struct OctomapMap::Impl {
  explicit Impl(double voxel_size_m) : tree(voxel_size_m) {}

  octomap::OcTree tree;
  octomap::Pointcloud cloud_S;
  octomap::point3d sensor_S;
  double max_range_m = 0;
};

OctomapMap::OctomapMap(const VoxelConfig& config)
    : impl_(std::make_unique<Impl>(config.voxel_size_m)) {
  octomap::OcTree& tree = impl_->tree;
  tree.setOccupancyThres(0.5);
  tree.setProbHit(octomap::probability(config.log_odds_hit));
  tree.setProbMiss(octomap::probability(config.log_odds_miss));
  tree.setClampingThresMin(octomap::probability(config.log_odds_min));
  tree.setClampingThresMax(octomap::probability(config.log_odds_max));
  impl_->max_range_m = config.max_range_m;
}

OctomapMap::~OctomapMap() = default;

void OctomapMap::prepare(const std::vector<Beam>& beams, const Eigen::Vector3f& sensor_S) {
  impl_->cloud_S.clear();
  impl_->cloud_S.reserve(beams.size());
  for (const Beam& beam : beams) {
    impl_->cloud_S.push_back(beam.end_S.x(), beam.end_S.y(), beam.end_S.z());
  }
  impl_->sensor_S = {sensor_S.x(), sensor_S.y(), sensor_S.z()};
}

void OctomapMap::integrate() {
  impl_->tree.insertPointCloud(impl_->cloud_S, impl_->sensor_S, impl_->max_range_m,
                               /*lazy_eval=*/false, /*discretize=*/false);
}

VoxelState OctomapMap::state(const Eigen::Vector3f& p_S) const {
  const octomap::OcTreeNode* node = impl_->tree.search(p_S.x(), p_S.y(), p_S.z());
  if (node == nullptr) return VoxelState::kUnknown;
  return impl_->tree.isNodeOccupied(node) ? VoxelState::kOccupied : VoxelState::kFree;
}

double OctomapMap::observed_m3() const {
  double observed_m3 = 0;
  for (auto leaf = impl_->tree.begin_leafs(); leaf != impl_->tree.end_leafs(); ++leaf) {
    observed_m3 += std::pow(leaf.getSize(), 3);
  }
  return observed_m3;
}

std::size_t OctomapMap::bytes() const { return impl_->tree.memoryUsage(); }

}  // namespace cloister
