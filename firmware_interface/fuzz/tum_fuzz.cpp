#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware_interface/files/odometry_buffer.hpp"
#include "firmware_interface/files/tum_file.hpp"

/// Any text is either refused or gives an ascending trajectory that can be asked for any pose.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using cloister::Duration;
  using cloister::OdometryBuffer;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto poses = cloister::read_tum(text, "input");
  if (!poses || poses->empty()) return 0;
  for (std::size_t k = 0; k < poses->size(); ++k) {
    if (!cloister::is_finite(poses->at(k).T_O_B)) std::abort();
    if (k > 0 && poses->at(k).stamp <= poses->at(k - 1).stamp) std::abort();
  }
  const auto begin = poses->front().stamp - Duration{10'000'000};
  const auto end = poses->back().stamp + Duration{10'000'000};
  const OdometryBuffer odometry(std::move(*poses));
  const OdometryBuffer::Limits limits{Duration{1'000'000'000}, Duration{500'000'000}};
  std::vector<cloister::PoseSample> samples;
  const bool covered =
      odometry.cover(begin, end, limits, 16, samples) == OdometryBuffer::Coverage::kCovered;
  if (covered == samples.empty() || samples.size() > 16) std::abort();
  for (const auto& sample : samples) {
    if (!cloister::is_finite(sample.T_R_L)) std::abort();
  }
  return 0;
}
