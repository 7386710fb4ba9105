#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "firmware_interface/files/pcd_file.hpp"

/// Any bytes are either refused, leaving the points alone, or give finite points.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<Eigen::Vector3f> points(1, Eigen::Vector3f::Zero());
  const auto stats =
      cloister::read_pcd({reinterpret_cast<const char*>(data), size}, "input", points);
  const std::size_t num_added = stats ? static_cast<std::size_t>(stats->points) : 0;
  if (points.size() != 1 + num_added) std::abort();
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) std::abort();
  }
  return 0;
}
