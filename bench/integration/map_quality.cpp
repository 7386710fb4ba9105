#include "bench/integration/map_quality.hpp"

namespace cloister {
namespace {

// Points before the end of a beam must be this many voxels away from it.
constexpr float kVoxelsBeforeEnd = 3;

VoxelState state_of_end(const Eigen::Vector3f& end_S, const Eigen::Vector3f& step_S,
                        const StateAt& state_at) {
  bool is_known = false;
  for (const float steps : {0.0f, -1.0f, 1.0f}) {
    const VoxelState state = state_at(end_S + steps * step_S);
    if (state == VoxelState::kOccupied) return state;
    is_known |= state == VoxelState::kFree;
  }
  return is_known ? VoxelState::kFree : VoxelState::kUnknown;
}

}  // namespace

double StateCounts::share(VoxelState state) const {
  const std::size_t all = total();
  return all == 0 ? 0
                  : static_cast<double>(counts[static_cast<std::size_t>(state)]) /
                        static_cast<double>(all);
}

void judge_beam(const Beam& beam, float voxel_m, const StateAt& state_at, BeamQuality& quality) {
  const Eigen::Vector3f along_S = beam.end_S - beam.origin_S;
  const float range_m = along_S.norm();
  for (int percent = 10; percent <= 95; percent += 5) {
    const float share = 0.01f * static_cast<float>(percent);
    if ((1 - share) * range_m <= kVoxelsBeforeEnd * voxel_m) break;
    quality.before_end.add(state_at(beam.origin_S + share * along_S));
  }
  const VoxelState end = state_of_end(beam.end_S, along_S * (voxel_m / range_m), state_at);
  quality.ends.add(end);
  if (beam.is_ground) quality.ground_ends.add(end);
  for (std::size_t i = 0; i < quality.ends_by_range.size(); ++i) {
    if (range_m >= BeamQuality::kRangeLimitsM[i] && range_m < BeamQuality::kRangeLimitsM[i + 1]) {
      quality.ends_by_range[i].add(end);
    }
  }
}

double TruthQuality::false_occupied() const {
  const auto count = [&](VoxelState state) {
    return static_cast<double>(in_free_space.counts[static_cast<std::size_t>(state)]);
  };
  const double known = count(VoxelState::kFree) + count(VoxelState::kOccupied);
  return known == 0 ? 0 : count(VoxelState::kOccupied) / known;
}

TruthQuality judge_points(const std::vector<TruthPoint>& points, const Eigen::Vector3d& origin_A,
                          const StateAt& state_at) {
  TruthQuality quality;
  for (const TruthPoint& point : points) {
    const VoxelState state = state_at((point.p_A - origin_A).cast<float>());
    (point.is_solid ? quality.in_solids : quality.in_free_space).add(state);
  }
  return quality;
}

}  // namespace cloister
