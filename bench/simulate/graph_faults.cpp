#include "bench/simulate/graph_faults.hpp"

#include <algorithm>
#include <cmath>

namespace cloister {

std::optional<RelativeMeasurement> make_wrong_closure(const std::vector<Pose>& T_W_nodes,
                                                      std::size_t min_gap,
                                                      const Vector6d& good_sigma,
                                                      Confidence confidence, RandomStream* random) {
  constexpr double kNearest_m = 7.0;
  constexpr double kFarthest_m = 20.0;
  constexpr double kClaimed_m = 0.7;    // between the two nodes, as the closure sees it
  constexpr double kHeading_rad = 0.1;  // corridors alike run the same way
  const std::size_t newest = T_W_nodes.size() - 1;
  std::vector<std::size_t> candidates;
  for (std::size_t k = 0; k + min_gap < newest; ++k) {
    const double distance = (T_W_nodes[k].translation() - T_W_nodes[newest].translation()).norm();
    if (distance > kNearest_m && distance < kFarthest_m) candidates.push_back(k);
  }
  if (candidates.empty()) return std::nullopt;

  const std::size_t old = candidates[random->below(candidates.size())];
  const Pose T_old_newest = T_W_nodes[old].inverse() * T_W_nodes[newest];
  const Eigen::Vector3d claimed_m(kClaimed_m * random->normal(), kClaimed_m * random->normal(),
                                  0.1 * kClaimed_m * random->normal());
  const Eigen::AngleAxisd turn(kHeading_rad * random->normal(), Eigen::Vector3d::UnitZ());
  RelativeMeasurement closure{old, newest, Pose(T_old_newest), Information::Identity()};
  closure.T_from_to.translation() = claimed_m;
  closure.T_from_to.linear() = T_old_newest.linear() * turn;
  Vector6d sigma = good_sigma;
  if (confidence == Confidence::kDoubtful) {
    sigma.head<3>().setConstant((claimed_m - T_old_newest.translation()).norm());
    sigma.tail<3>().setConstant(3.0 * kHeading_rad);
  }
  closure.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  return closure;
}

double LateShift::offset_m(std::size_t node) const {
  const double share = static_cast<double>(node) / static_cast<double>(num_nodes_);
  return shift_m_ * std::clamp((0.5 - share) / (0.5 - 1.0 / 3.0), 0.0, 1.0);
}

bool LateShift::is_unnoticed(std::size_t nodes) const {
  constexpr double kLate = 0.8;
  return shift_m_ > 0.0 && static_cast<double>(nodes) < kLate * static_cast<double>(num_nodes_);
}

FaultyGraph LateShift::apply(const std::vector<Pose>& T_M_nodes,
                             const std::vector<RelativeMeasurement>& measurements) const {
  constexpr double kNotRecognised_m = 0.1;
  // Along x and y alike.
  const Eigen::Vector3d aside = Eigen::Vector3d(1.0, 1.0, 0.0).normalized();
  FaultyGraph graph{T_M_nodes, {}};
  for (std::size_t k = 0; k < T_M_nodes.size(); ++k)
    graph.T_M_nodes[k].translation() += offset_m(k) * aside;
  for (RelativeMeasurement m : measurements) {
    const double bend_m = std::abs(offset_m(m.from) - offset_m(m.to));
    const bool is_closure = m.from + 1 != m.to;
    if (is_closure && bend_m > kNotRecognised_m) continue;
    const Pose T_from_to = T_M_nodes[m.from].inverse() * T_M_nodes[m.to];
    const Pose T_from_to_aside = graph.T_M_nodes[m.from].inverse() * graph.T_M_nodes[m.to];
    m.T_from_to = T_from_to_aside * T_from_to.inverse() * m.T_from_to;
    graph.measurements.push_back(m);
  }
  return graph;
}

}  // namespace cloister
