#include "mapping/fuse/shared_sight.hpp"

#include <algorithm>
#include <vector>

#include <Eigen/Geometry>

namespace cloister {
namespace {

constexpr std::size_t kPathPoints = 10;
constexpr float kAsideM = 1.0f;

/// Lines of sight through two submaps, in a's frame.
class Sight {
 public:
  Sight(const VoxelStore& store, double voxel_size_m, const Submap& a, const Submap& b)
      : store_(store),
        voxel_m_(static_cast<float>(voxel_size_m)),
        a_(a),
        b_(b),
        T_b_a_((b.T_M_S.inverse() * a.T_M_S).cast<float>()) {}

  [[nodiscard]] bool is_clear(const Eigen::Vector3f& from_a, const Eigen::Vector3f& to_a) const {
    const int num_steps = std::max(1, static_cast<int>((to_a - from_a).norm() / voxel_m_));
    const Eigen::Vector3f step_a = (to_a - from_a) / static_cast<float>(num_steps);
    int num_known = 0;
    for (int i = 0; i <= num_steps; ++i) {
      const Eigen::Vector3f p_a = from_a + static_cast<float>(i) * step_a;
      const LogOdds in_a = at(a_, p_a), in_b = at(b_, T_b_a_ * p_a);
      if (in_a > 0 || in_b > 0) return false;
      num_known += in_a != kUnknownLogOdds || in_b != kUnknownLogOdds;
    }
    return 2 * num_known > num_steps;
  }

  /// Points of a submap's path, and clear ones beside them.
  [[nodiscard]] std::vector<Eigen::Vector3f> places_of(const Submap& submap,
                                                       const Eigen::Isometry3f& T_a_S) const {
    std::vector<Eigen::Vector3f> places_a;
    const auto points = submap.path.points();
    const std::size_t stride = (points.size() + kPathPoints - 1) / kPathPoints;
    for (std::size_t i = 0; i < points.size(); i += stride) {
      const Eigen::Vector3f p_a = T_a_S * points[i];
      places_a.push_back(p_a);
      for (const int axis : {0, 1}) {
        for (const float side_m : {-kAsideM, kAsideM}) {
          const Eigen::Vector3f aside_a = p_a + side_m * Eigen::Vector3f::Unit(axis);
          if (is_clear(p_a, aside_a)) places_a.push_back(aside_a);
        }
      }
    }
    return places_a;
  }

  [[nodiscard]] Eigen::Isometry3f T_a_b() const { return T_b_a_.inverse(); }

 private:
  [[nodiscard]] LogOdds at(const Submap& submap, const Eigen::Vector3f& p_S) const {
    return submap.volume.at(store_, (p_S / voxel_m_).array().floor().matrix().cast<int>());
  }

  const VoxelStore& store_;
  float voxel_m_;
  const Submap& a_;
  const Submap& b_;
  Eigen::Isometry3f T_b_a_;
};

}  // namespace

double shared_sight(const VoxelStore& store, double voxel_size_m, const Submap& a,
                    const Submap& b) {
  const Sight sight(store, voxel_size_m, a, b);
  const std::vector<Eigen::Vector3f> of_a = sight.places_of(a, Eigen::Isometry3f::Identity());
  const std::vector<Eigen::Vector3f> of_b = sight.places_of(b, sight.T_a_b());
  const std::size_t num_lines = of_a.size() * of_b.size();
  if (num_lines == 0) return 0;
  std::size_t num_clear = 0;
  for (const Eigen::Vector3f& p_a : of_a) {
    for (const Eigen::Vector3f& q_a : of_b) num_clear += sight.is_clear(p_a, q_a);
  }
  return static_cast<double>(num_clear) / static_cast<double>(num_lines);
}

}  // namespace cloister
