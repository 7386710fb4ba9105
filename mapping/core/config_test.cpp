#include "mapping/core/config.hpp"

#include <doctest/doctest.h>

#include <limits>

namespace cloister {
namespace {

TEST_CASE("the defaults are valid") { CHECK_FALSE(validate(Config{}).has_value()); }

TEST_CASE("a value out of bounds is named with field, value and bound") {
  Config config;
  config.voxel.voxel_size_m = 5;
  const auto problem = validate(config);
  REQUIRE(problem.has_value());
  CHECK(*problem == "voxel.voxel_size_m = 5: must be between 0.01 and 1");
}

TEST_CASE("a value that is not a number is refused") {
  Config config;
  config.fusion.max_sigma_m = std::numeric_limits<double>::quiet_NaN();
  CHECK(validate(config).value_or("").find("fusion.max_sigma_m") == 0);
}

TEST_CASE("ranges that exclude each other are refused") {
  Config config;
  config.voxel.min_range_m = 20;
  config.voxel.max_range_m = 10;
  CHECK(validate(config).value_or("").find("voxel.min_range_m = 20") == 0);
}

TEST_CASE("a range of too many voxels is refused") {
  Config config;
  config.voxel.voxel_size_m = 0.01;
  config.voxel.max_range_m = 200;
  CHECK(validate(config).value_or("").find("voxel.max_range_m = 200") == 0);
}

TEST_CASE("a budget that the submaps' slots alone would fill is refused") {
  Config config;
  config.memory.budget_bytes = 64 << 20;
  config.memory.max_submaps = 5000;
  CHECK(validate(config).value_or("").find("memory.max_submaps = 5000") == 0);
}

}  // namespace
}  // namespace cloister
