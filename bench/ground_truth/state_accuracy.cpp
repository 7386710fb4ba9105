#include "bench/ground_truth/state_accuracy.hpp"

#include <fstream>

#include <Eigen/Geometry>

#include "bench/simulate/number_text.hpp"
#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

/// The part of the world a mission can be asked about.
class ObservedRegion {
 public:
  explicit ObservedRegion(const GroundTruth& truth) {
    // Slabs are part of the question (is the floor taken for free?), the ground below and the sky are not.
    constexpr double kIntoSlab_m = 0.2;
    const Eigen::Vector3d around(10.0, 10.0, 3.0);
    constexpr double kEvery_m = 2.0;
    const auto add = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
      parts_.emplace_back(low, high);
      bounds_.extend(parts_.back());
    };
    for (const Room& room : truth.rooms) {
      add(room.min_W - Eigen::Vector3d(0.0, 0.0, kIntoSlab_m),
          room.max_W + Eigen::Vector3d(0.0, 0.0, kIntoSlab_m));
    }
    if (!parts_.empty()) return;
    Eigen::Vector3d last = Eigen::Vector3d::Constant(1e9);
    for (const StampedPose& pose : truth.T_W_L) {
      const Eigen::Vector3d p = pose.pose.translation();
      if ((p - last).norm() < kEvery_m) continue;
      last = p;
      add(p - around, p + around);
    }
  }

  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  [[nodiscard]] bool contains(const Eigen::Vector3d& p) const {
    for (const Eigen::AlignedBox3d& part : parts_) {
      if (part.contains(p)) return true;
    }
    return false;
  }

 private:
  std::vector<Eigen::AlignedBox3d> parts_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace

std::vector<TruePoint> sample_points(const GroundTruth& truth, const RayScene& scene_W,
                                     std::size_t count, double clearance_m, std::uint64_t seed) {
  constexpr std::size_t kAttemptsPerPoint = 200;
  const ObservedRegion region(truth);
  RandomStream random = random_stream(seed, Purpose::kSampling);
  const auto clearance = static_cast<float>(clearance_m);
  std::vector<TruePoint> points;
  points.reserve(count);
  for (std::size_t attempt = 0; attempt < count * kAttemptsPerPoint && points.size() < count;
       ++attempt) {
    const Eigen::Vector3d share(random.uniform(), random.uniform(), random.uniform());
    const Eigen::Vector3d p_W = region.bounds().min() + share.cwiseProduct(region.bounds().sizes());
    if (!region.contains(p_W) || scene_W.distance(p_W.cast<float>(), 2.0F * clearance) <= clearance)
      continue;
    points.push_back({p_W, scene_W.is_inside(p_W.cast<float>())});
  }
  return points;
}

std::string format_points(const std::vector<TruePoint>& points, const Pose& T_W_M) {
  const Pose T_M_W = T_W_M.inverse();
  std::string text = "x,y,z\n";
  for (const TruePoint& point : points) {
    const Eigen::Vector3d p_M = T_M_W * point.p_W;
    for (int k = 0; k < 3; ++k) {
      append_number(p_M[k], &text);
      text += k < 2 ? ',' : '\n';
    }
  }
  return text;
}

Result<std::vector<PointState>> read_states(const std::filesystem::path& file, std::size_t count) {
  std::ifstream stream(file);
  if (!stream)
    return fail(ErrorKind::kInput, file.string() + ": cannot be opened: did the query write it?");
  std::vector<PointState> states;
  states.reserve(count);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto cells = split_words(line, ",\r");
    double x = 0.0;
    if (cells.empty() || (number == 1 && !parse_number(cells[0], &x))) continue;  // the header
    const std::string_view state = cells.size() < 4 ? std::string_view() : cells[3];
    if (state == "free") {
      states.push_back(PointState::kFree);
    } else if (state == "occupied") {
      states.push_back(PointState::kOccupied);
    } else if (state == "unknown") {
      states.push_back(PointState::kUnknown);
    } else {
      return fail(ErrorKind::kInput, file.string() + ":" + std::to_string(number) +
                                         ": the fourth cell must be occupied, free or unknown");
    }
  }
  if (states.size() != count) {
    return fail(ErrorKind::kInput, file.string() + ": answers " + std::to_string(states.size()) +
                                       " of " + std::to_string(count) +
                                       " points: run the query again");
  }
  return states;
}

StateAccuracy compare_states(const std::vector<TruePoint>& points,
                             const std::vector<PointState>& states) {
  StateAccuracy result;
  result.points = points.size();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const bool is_solid = points[k].is_solid;
    result.truly_free += is_solid ? 0 : 1;
    if (states[k] == PointState::kFree) {
      ++result.known_free;
      result.known_free_right += is_solid ? 0 : 1;
    } else if (states[k] == PointState::kOccupied) {
      ++result.known_occupied;
      result.known_occupied_wrong += is_solid ? 0 : 1;
    } else {
      ++result.unknown;
    }
  }
  return result;
}

}  // namespace cloister
