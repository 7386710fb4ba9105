#include "bench/integration/cloister_map.hpp"

#include <cmath>

#include "mapping/overlap/voxel_overlap.hpp"
#include "mapping/scan/scan_motion.hpp"

namespace cloister {
namespace {

// As the program divides its budget between blocks and chunks.
constexpr double kBlockShare = 0.75;

std::size_t items_in(double bytes, std::size_t item_bytes) {
  return static_cast<std::size_t>(bytes) / item_bytes;
}

}  // namespace

CloisterMap::CloisterMap(const Config& config, std::size_t max_pixels, std::int64_t budget_bytes)
    : config_(config.voxel),
      store_(items_in(kBlockShare * static_cast<double>(budget_bytes), sizeof(Block)),
             items_in((1 - kBlockShare) * static_cast<double>(budget_bytes), sizeof(Chunk))),
      warmer_(store_),
      pools_(store_),
      beams_(max_pixels),
      integrator_(config.voxel) {
  pools_.take_all();
  keep_memory_ahead();
}

void CloisterMap::place(const Scan& scan, const Pose& T_S_R) {
  num_declined_ += beams_.assign(scan, T_S_R, config_);
  sensor_S_ = (T_S_R * ScanMotion(scan.poses).T_R_L(scan.stamp)).translation().cast<float>();
}

std::size_t CloisterMap::integrate_placed() {
  const IntegrationResult result = integrator_.integrate(beams_, sensor_S_, pools_, volume_);
  num_declined_ += result.voxels_declined;
  return result.blocks_hit + result.blocks_free + result.blocks_mixed;
}

VoxelState CloisterMap::state(const Eigen::Vector3f& p_S) const {
  const Eigen::Vector3f v = p_S / static_cast<float>(config_.voxel_size_m);
  return state_of(volume_.at(store_, v.array().floor().matrix().cast<int>()));
}

double CloisterMap::observed_m3() const {
  return static_cast<double>(count_known(store_, volume_)) * std::pow(config_.voxel_size_m, 3);
}

std::vector<ByteShare> CloisterMap::byte_shares() const {
  return {{"block of 8x8x8 voxels", volume_.num_blocks(), sizeof(Block)},
          {"chunk of 8x8x8 places", volume_.num_chunks(), sizeof(Chunk)},
          {"volume with its hash table", 1, sizeof(Volume)}};
}

}  // namespace cloister
