#include "bench/simulate/path_file.hpp"

#include <cmath>
#include <fstream>

#include "bench/simulate/number_text.hpp"

namespace cloister {

Result<Trajectory> read_path(const std::filesystem::path& path, const WalkConfig& config,
                             SensorTime start, std::uint64_t seed) {
  std::ifstream stream(path);
  if (!stream) return fail(ErrorKind::kInput, path.string() + ": cannot be opened: check the path");
  std::vector<Waypoint> waypoints;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto words = split_words(line);
    if (words.empty()) continue;
    const auto bad = [&](const std::string& what) {
      return fail(ErrorKind::kInput, path.string() + ":" + std::to_string(number) + ": " + what);
    };
    if (words.size() == 8 && waypoints.empty()) {
      const auto poses = read_tum(path);
      if (!poses) return tl::unexpected(poses.error());
      return resample(*poses, start);
    }
    if (words.size() != 3 && words.size() != 4) {
      return bad("a line is x y z, x y z pause_s, or a TUM pose of eight numbers");
    }
    double values[4] = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < words.size(); ++k) {
      if (!parse_number(words[k], &values[k]) || !std::isfinite(values[k]))
        return bad("not a finite number");
    }
    if (values[3] < 0.0) return bad("a pause cannot be negative");
    const Eigen::Vector3d position(values[0], values[1], values[2]);
    if (!waypoints.empty() && (position - waypoints.back().position_W).norm() < 0.01) {
      return bad("the same place as the line before: leave it out");
    }
    waypoints.push_back({position, values[3]});
  }
  if (waypoints.size() < 2) {
    return fail(ErrorKind::kInput, path.string() + ": a path needs at least two places: add some");
  }
  return walk(waypoints, config, start, seed);
}

}  // namespace cloister
