#include "bench/simulate/scan_simulator.hpp"

#include <algorithm>
#include <cmath>

#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

constexpr float kDarkAlbedo = 0.1F;
constexpr float kDefaultAlbedo = 0.4F;

/// Probability that a return is detected, from its strength against the threshold: a steep logistic
/// of its logarithm, written as a power so that it costs one multiplication (exponent 4).
double detection_probability(double strength) {
  const double power = strength * strength * strength * strength;
  return power / (1.0 + power);
}

std::uint16_t clamp_u16(double value) {
  return static_cast<std::uint16_t>(std::clamp(value, 0.0, 65'535.0));
}

}  // namespace

ScanSimulator::ScanSimulator(const SensorModel& sensor, const TriangleMesh& mesh,
                             const RayScene& scene, std::uint64_t seed)
    : sensor_(sensor), mesh_(mesh), scene_(scene), seed_(seed), fan_(make_beam_fan(sensor)) {}

SensorTime ScanSimulator::column_stamp(SensorTime start, std::uint64_t scan, int column) const {
  const auto columns = static_cast<std::int64_t>(sensor_.columns);
  const std::int64_t index = static_cast<std::int64_t>(scan) * columns + column;
  return {start.ns + index * (1'000'000'000 / sensor_.rate_hz) / columns};
}

void ScanSimulator::simulate(const Trajectory& truth, SensorTime start, std::uint64_t scan,
                             std::span<PixelReturn> pixels) const {
  const auto beams = static_cast<std::size_t>(sensor_.beams());
  const double origin_offset_m = sensor_.beam_origin_mm * 1e-3;
  const double threshold = kDarkAlbedo / (sensor_.dark_range_m * sensor_.dark_range_m);
  std::vector<Eigen::Vector3f> directions_W(beams);
  std::vector<RayHit> hits(beams);
  for (int column = 0; column < sensor_.columns; ++column) {
    const auto c = static_cast<std::size_t>(column);
    const Pose T_W_L = truth.at(column_stamp(start, scan, column));
    const Eigen::Matrix3f R_W_L = T_W_L.linear().cast<float>();
    const Eigen::Vector3f origin_W = (T_W_L * fan_.origins_L[c].cast<double>()).cast<float>();
    for (std::size_t beam = 0; beam < beams; ++beam) {
      directions_W[beam] = R_W_L * fan_.directions_L[c * beams + beam];
    }
    scene_.cast(origin_W, directions_W, static_cast<float>(sensor_.max_range_m), hits);

    RandomStream random = random_stream(seed_, Purpose::kReturns,
                                        scan * static_cast<std::uint64_t>(sensor_.columns) + c);
    for (std::size_t beam = 0; beam < beams; ++beam) {
      PixelReturn& pixel = pixels[c * beams + beam];
      pixel = PixelReturn{};
      const double luck = random.uniform();
      const double noise_m = sensor_.noise_m * random.normal();
      const RayHit& hit = hits[beam];
      pixel.near_ir = 120;
      if (hit.triangle == RayHit::kNone || hit.distance_m < static_cast<float>(sensor_.min_range_m))
        continue;
      const float albedo = mesh_.albedo.empty() ? kDefaultAlbedo : mesh_.albedo[hit.triangle];
      const double returned = albedo * hit.cos_incidence / (hit.distance_m * hit.distance_m);
      if (luck >= (1.0 - sensor_.dropout) * detection_probability(returned / threshold)) continue;
      const double range_m = hit.distance_m + origin_offset_m + noise_m;
      pixel.range_mm = static_cast<std::uint32_t>(std::lround(range_m * 1e3));
      pixel.reflectivity = clamp_u16(255.0 * albedo);
      pixel.signal = clamp_u16(4.0 * returned / threshold);
    }
  }
}

}  // namespace cloister
