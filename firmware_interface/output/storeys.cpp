#include "firmware_interface/output/storeys.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace cloister {
namespace {

constexpr double kMaxCoordinate_m = 1e7;  // further out is no place but an error
constexpr double kStep_m = 0.2;           // between path points, so that length counts, not time
constexpr double kBin_m = 0.2;            // of the histogram of heights
constexpr double kMinStorey_m = 1.5;      // between the sensor's heights on two levels
constexpr double kMaxDip = 0.4;           // of the lower of two peaks: more path between joins them
constexpr double kLevelBand_m = 0.25;     // path further than this from a level's height is stairs
constexpr double kFootprint_m = 2.0;      // cell in which two levels are compared
constexpr double kMinShared = 0.1;        // of the smaller footprint: less is not one above another

using Points = std::vector<Eigen::Vector3d>;

Points resample(const std::vector<std::pair<SensorTime, Pose>>& path_M) {
  Points points;
  for (const auto& [stamp, T_M_L] : path_M) {
    const Eigen::Vector3d p_M = T_M_L.translation();
    if (!p_M.allFinite() || p_M.cwiseAbs().maxCoeff() > kMaxCoordinate_m) continue;
    if (points.empty() || (p_M - points.back()).norm() >= kStep_m) points.push_back(p_M);
  }
  return points;
}

// How much path there is at each height, smoothed over five bins.
// Bin k is centred at low_m + k * kBin_m.
struct HeightProfile {
  double low_m = 0;
  std::vector<double> weight;

  explicit HeightProfile(const Points& points) {
    const auto [low, high] = std::minmax_element(
        points.begin(), points.end(), [](const auto& p, const auto& q) { return p.z() < q.z(); });
    low_m = low->z() - 2 * kBin_m;
    const double bins = std::min((high->z() - low_m) / kBin_m, 100'000.0);
    std::vector<double> counts(static_cast<std::size_t>(bins) + 5, 0.0);
    for (const auto& p : points) counts[std::min(bin(p.z()), counts.size() - 3)] += 1.0;
    weight.assign(counts.size(), 0.0);
    for (std::size_t k = 2; k + 2 < counts.size(); ++k) {
      weight[k] =
          counts[k - 2] + 2 * counts[k - 1] + 3 * counts[k] + 2 * counts[k + 1] + counts[k + 2];
    }
  }
  [[nodiscard]] std::size_t bin(double z_m) const {
    return static_cast<std::size_t>(std::max(0.0, std::round((z_m - low_m) / kBin_m)));
  }
  [[nodiscard]] double height_m(std::size_t k) const {
    return low_m + kBin_m * static_cast<double>(k);
  }
};

// Bins of the peaks that stay when those too close to a higher neighbour, or not clearly apart from
// it, are taken away.
std::vector<std::size_t> find_peaks(const std::vector<double>& weight) {
  std::vector<std::size_t> peaks;
  for (std::size_t k = 1; k + 1 < weight.size(); ++k) {
    if (weight[k] > 0 && weight[k] > weight[k - 1] && weight[k] >= weight[k + 1])
      peaks.push_back(k);
  }
  for (std::size_t i = 0; i + 1 < peaks.size();) {
    const std::size_t low = peaks[i];
    const std::size_t high = peaks[i + 1];
    const double dip = *std::min_element(&weight[low], &weight[high]);
    const bool apart = static_cast<double>(high - low) * kBin_m >= kMinStorey_m &&
                       dip <= kMaxDip * std::min(weight[low], weight[high]);
    if (apart) {
      ++i;
    } else {
      peaks.erase(peaks.begin() +
                  static_cast<std::ptrdiff_t>(weight[low] < weight[high] ? i : i + 1));
      i = i > 0 ? i - 1 : 0;
    }
  }
  return peaks;
}

using Footprint = std::set<std::pair<long, long>>;

Footprint footprint(const Points& points, int margin_cells) {
  Footprint cells;
  for (const auto& p : points) {
    const long column = std::lround(p.x() / kFootprint_m);
    const long row = std::lround(p.y() / kFootprint_m);
    for (int dx = -margin_cells; dx <= margin_cells; ++dx) {
      for (int dy = -margin_cells; dy <= margin_cells; ++dy) cells.emplace(column + dx, row + dy);
    }
  }
  return cells;
}

bool lie_above_each_other(const Points& a_M, const Points& b_M) {
  const Points& smaller = a_M.size() < b_M.size() ? a_M : b_M;
  const Footprint wide = footprint(&smaller == &a_M ? b_M : a_M, 1);
  const Footprint narrow = footprint(smaller, 0);
  const auto shared = std::count_if(narrow.begin(), narrow.end(),
                                    [&](const auto& cell) { return wide.contains(cell); });
  return static_cast<double>(shared) > kMinShared * static_cast<double>(narrow.size());
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Storeys find_storeys(const std::vector<std::pair<SensorTime, Pose>>& path_M) {
  Storeys result;
  result.of_pose.assign(path_M.size(), 0);
  result.storeys.emplace_back();
  const Points points = resample(path_M);
  if (points.empty()) return result;

  const HeightProfile profile(points);
  const std::vector<std::size_t> peaks = find_peaks(profile.weight);

  // Levels bottom up, and the height above which the next one begins: the lowest dip between peaks.
  std::vector<double> ceilings_m;
  for (std::size_t i = 0; i + 1 < peaks.size(); ++i) {
    const auto dip =
        std::min_element(profile.weight.begin() + static_cast<std::ptrdiff_t>(peaks[i]),
                         profile.weight.begin() + static_cast<std::ptrdiff_t>(peaks[i + 1]));
    ceilings_m.push_back(profile.height_m(static_cast<std::size_t>(dip - profile.weight.begin())));
  }
  std::vector<Points> levels(peaks.size());
  for (const auto& p : points) {
    for (std::size_t i = 0; i < peaks.size(); ++i) {
      if (std::abs(p.z() - profile.height_m(peaks[i])) <= kLevelBand_m) levels[i].push_back(p);
    }
  }
  for (std::size_t i = 0; i + 1 < levels.size();) {
    if (lie_above_each_other(levels[i], levels[i + 1])) {
      ++i;
      continue;
    }
    levels[i].insert(levels[i].end(), levels[i + 1].begin(), levels[i + 1].end());
    levels.erase(levels.begin() + static_cast<std::ptrdiff_t>(i + 1));
    ceilings_m.erase(ceilings_m.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (levels.size() == 1)
    levels[0] = points;  // nothing to keep apart: slopes between levels count as well

  result.storeys.resize(levels.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    std::vector<double> heights;
    for (const auto& p : levels[i]) heights.push_back(p.z());
    result.storeys[i] = {median(std::move(heights)), std::move(levels[i])};
  }
  for (std::size_t k = 0; k < path_M.size(); ++k) {
    const double z = path_M[k].second.translation().z();
    result.of_pose[k] = static_cast<std::size_t>(
        std::count_if(ceilings_m.begin(), ceilings_m.end(), [z](double c) { return z > c; }));
  }
  return result;
}

GroundLevel::GroundLevel(const Storey& storey, const Eigen::Vector2d& min_M,
                         const Eigen::Vector2d& max_M)
    : min_M_(min_M) {
  const Eigen::Vector2d extent_m = max_M - min_M;
  cell_m_ = std::max(2.0, extent_m.maxCoeff() / 200.0);
  columns_ = static_cast<int>(extent_m.x() / cell_m_) + 1;
  rows_ = static_cast<int>(extent_m.y() / cell_m_) + 1;
  z_.assign(static_cast<std::size_t>(columns_) * rows_, storey.sensor_z_m);
  near_.assign(z_.size(), 0);

  // Brute force over a path thinned to a thousand points or two; some 40 thousand cells at most.
  // The median of the nearest stretch, not the nearest point, which may be on the stairs already.
  const std::size_t stride = storey.level_M.size() / 1000 + 1;
  std::vector<double> distances_m, stretch_z;
  for (std::size_t i = 0; i < z_.size() && !storey.level_M.empty(); ++i) {
    const Eigen::Vector2d centre_M =
        min_M + cell_m_ * Eigen::Vector2d(static_cast<double>(i % columns_) + 0.5,
                                          static_cast<double>(i / columns_) + 0.5);
    distances_m.clear();
    for (std::size_t k = 0; k < storey.level_M.size(); k += stride) {
      distances_m.push_back((storey.level_M[k].head<2>() - centre_M).norm());
    }
    const double nearest_m = *std::min_element(distances_m.begin(), distances_m.end());
    stretch_z.clear();
    for (std::size_t k = 0; k < distances_m.size(); ++k) {
      if (distances_m[k] <= nearest_m + 1.0) stretch_z.push_back(storey.level_M[k * stride].z());
    }
    z_[i] = median(stretch_z);
    near_[i] = nearest_m <= cell_m_ ? 1 : 0;
  }
}

std::size_t GroundLevel::cell(double x_M, double y_M) const {
  const auto clamped = [this](double offset_m, int count) {
    return static_cast<int>(std::clamp(offset_m / cell_m_, 0.0, count - 1.0));
  };
  return static_cast<std::size_t>(clamped(y_M - min_M_.y(), rows_)) * columns_ +
         clamped(x_M - min_M_.x(), columns_);
}

}  // namespace cloister
