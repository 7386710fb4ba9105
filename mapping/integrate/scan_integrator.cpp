#include "mapping/integrate/scan_integrator.hpp"

#include <bit>

namespace cloister {
namespace {

// A full turn of an OS1 outdoors crosses about 105,000 blocks; twice that leaves room.
constexpr std::size_t kMaxScanBlocks = 1 << 18;
// How far the sensor may be from the middle of the window while it turns once.
constexpr double kWindowSlackM = 5.0;

std::size_t count_bits(const std::uint64_t (&words)[kBlockEdge]) {
  std::size_t count = 0;
  for (const std::uint64_t word : words) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

template <typename Visitor>
void for_each_bit(std::uint64_t word, Visitor&& visit) {
  for (; word != 0; word &= word - 1) visit(std::countr_zero(word));
}

}  // namespace

ScanIntegrator::ScanIntegrator(const VoxelConfig& config)
    : marker_(config.voxel_size_m, config.max_range_m, kWindowSlackM, kMaxScanBlocks),
      hit_(log_odds_steps(config.log_odds_hit)),
      miss_(log_odds_steps(config.log_odds_miss)),
      lowest_(log_odds_steps(config.log_odds_min)),
      highest_(log_odds_steps(config.log_odds_max)) {}

std::size_t ScanIntegrator::apply(const RayMarker::Marked& marked, VoxelPools& pools, Volume& volume) const {
  std::uint64_t free[kBlockEdge];
  for (int z = 0; z < kBlockEdge; ++z) free[z] = marked.marks.free[z] & ~marked.marks.hit[z];
  const std::size_t num_free = count_bits(free);
  const std::size_t num_hits = count_bits(marked.marks.hit);

  Chunk* chunk = nullptr;
  std::uint32_t* place = volume.make_place(pools, marked.coord, &chunk);
  if (place == nullptr) return num_free + num_hits;

  if (num_hits == 0 && !Volume::has_block(*place)) {
    const LogOdds value = Volume::uniform_value(*place);
    if (value < 0 || (value == kUnknownLogOdds && num_free == kBlockVoxels)) {
      if (num_free >= kBlockVoxels / 2) {
        volume.set_uniform(pools, *chunk, *place, add_log_odds(value, miss_, lowest_, highest_));
      }
      return 0;
    }
  }
  Block* block = volume.make_block(pools, *chunk, *place);
  if (block == nullptr) return num_free + num_hits;
  for (int z = 0; z < kBlockEdge; ++z) {
    LogOdds* slice = block->voxels + z * kBlockEdge * kBlockEdge;
    for_each_bit(free[z], [&](int i) { slice[i] = add_log_odds(slice[i], miss_, lowest_, highest_); });
    for_each_bit(marked.marks.hit[z], [&](int i) { slice[i] = add_log_odds(slice[i], hit_, lowest_, highest_); });
  }
  if (num_hits == 0) volume.settle_block(pools, *chunk, *place);
  return 0;
}

IntegrationResult ScanIntegrator::integrate(const RayBundle& bundle, const Eigen::Vector3f& sensor_S,
                                            VoxelPools& pools, Volume& volume) {
  marker_.mark(bundle.rays(), sensor_S);
  IntegrationResult result;
  result.blocks_touched = marker_.num_blocks();
  result.voxels_declined = marker_.num_declined();
  for (std::size_t i = 0; i < marker_.num_blocks(); ++i) {
    result.voxels_declined += apply(marker_.block(i), pools, volume);
  }
  return result;
}

}  // namespace cloister
