#include "mapping/core/config.hpp"

#include <cmath>
#include <sstream>

#include "mapping/core/config_fields.hpp"

namespace cloister {

std::optional<std::string> validate(const Config& config) {
  std::optional<std::string> problem;
  const auto complain = [&](const auto&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    problem = text.str();
  };
  visit_fields(config, [&](const char* name, const auto& value, double least, double most) {
    const auto number = static_cast<double>(value);
    if (problem || (std::isfinite(number) && number >= least && number <= most)) return;
    complain(name, " = ", value, ": must be between ", least, " and ", most);
  });
  if (problem) return problem;
  if (config.voxel.min_range_m >= config.voxel.max_range_m) {
    complain("voxel.min_range_m = ", config.voxel.min_range_m, ": must be below voxel.max_range_m = ",
             config.voxel.max_range_m);
  }
  if (config.voxel.max_range_m / config.voxel.voxel_size_m > kMaxRangeVoxels) {
    complain("voxel.max_range_m = ", config.voxel.max_range_m, ": must be at most ", kMaxRangeVoxels,
             " voxels of voxel.voxel_size_m = ", config.voxel.voxel_size_m);
  }
  if (config.memory.max_submaps * kMaxSubmapSlotBytes > config.memory.budget_bytes / 2) {
    complain("memory.max_submaps = ", config.memory.max_submaps, ": their slots, ", kMaxSubmapSlotBytes,
             " bytes each, must fit into half of memory.budget_bytes = ", config.memory.budget_bytes);
  }
  return problem;
}

}  // namespace cloister
