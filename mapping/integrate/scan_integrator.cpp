#include "mapping/integrate/scan_integrator.hpp"

#include "mapping/integrate/block_update.hpp"
#include "mapping/integrate/projective.hpp"

namespace cloister {
namespace {

// A full turn of an OS1 outdoors crosses about 105,000 blocks; twice that leaves room.
constexpr std::size_t kMaxScanBlocks = 1 << 18;
// How far the sensor may be from the middle of the window while it turns once.
constexpr double kWindowSlackM = 5.0;

}  // namespace

ScanIntegrator::ScanIntegrator(const VoxelConfig& config, ScanWorkers* workers)
    : config_(config),
      evidence_(config),
      marks_(config.voxel_size_m, config.max_range_m, kWindowSlackM, kMaxScanBlocks) {
  if (workers != nullptr && workers->num() > 1) shared_.emplace(*workers);
}

IntegrationResult ScanIntegrator::integrate(const ScanBeams& scan, const Eigen::Vector3f& sensor_S,
                                            VoxelPools& pools, Volume& volume) {
  IntegrationResult result;
  marks_.restart(sensor_S);
  marks_.mark_returns(scan);
  result.blocks_hit = marks_.num_blocks();
  if (scan.is_image()) {
    const ProjectiveResult carved = integrate_projective(
        {scan.image(), evidence_, config_.voxel_size_m, config_.max_range_m, num_scans_,
         bare_turns_.turns(), marks_, pools, volume, shared_ ? &*shared_ : nullptr});
    // The first scan asks everything, whatever the turns: it says nothing about them.
    if (num_scans_++ > 0) {
      bare_turns_.choose(carved.blocks_coarse - carved.blocks_in_turn, carved.blocks_in_turn);
    }
    result.blocks_free = carved.blocks_free;
    result.blocks_mixed = carved.blocks_mixed + carved.blocks_coarse;
    result.voxels_declined = carved.voxels_declined;
  } else {
    for (const Ray& ray : scan.rays()) marks_.mark_crossed(ray);
    result.blocks_mixed = marks_.num_blocks();
  }
  for (std::size_t i = 0; i < marks_.num_blocks(); ++i) {
    if (marks_.block(i).is_applied) continue;
    result.voxels_declined += apply_marks(evidence_, marks_.block(i), pools, volume);
  }
  result.voxels_declined += marks_.num_declined();
  return result;
}

}  // namespace cloister
