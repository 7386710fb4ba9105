#include "bench/simulate/slam_standin.hpp"

#include <cmath>
#include <optional>

#include "bench/simulate/graph_faults.hpp"
#include "bench/simulate/number_text.hpp"
#include "bench/simulate/random_stream.hpp"

namespace cloister {

namespace {

void append_pose(const Pose& pose, std::string* text) {
  const Eigen::Quaterniond q(pose.linear());
  for (const double value : {pose.translation().x(), pose.translation().y(), pose.translation().z(),
                             q.x(), q.y(), q.z(), q.w()}) {
    *text += ' ';
    append_number(value, text);
  }
}

Information diagonal_information(const Vector6d& sigma) {
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

/// Standard deviations of odometry over a length: the drift's own model, plus what noise the two
/// ends have.
Vector6d odometry_sigma(const DriftConfig& drift, double length_m) {
  constexpr double kEnd_m = 0.002;
  constexpr double kEnd_rad = 0.0003;
  const double f = drift.factor();
  const double xy = std::hypot(f * drift.walk_m_per_sqrt_m * std::sqrt(length_m),
                               f * drift.scale * length_m, kEnd_m);
  const double z = std::hypot(f * drift.climb_m_per_sqrt_m * std::sqrt(length_m), kEnd_m);
  const double tilt = std::hypot(std::sqrt(2.0) * f * drift.tilt_rad, kEnd_rad);
  const double yaw = std::hypot(f * drift.yaw_rad_per_sqrt_m * std::sqrt(length_m), kEnd_rad);
  Vector6d sigma;
  sigma << xy, xy, z, tilt, tilt, yaw;
  return sigma;
}

/// The nearest old node within reach and sight, or nothing.
std::optional<std::size_t> recognise(const std::vector<Pose>& T_W_nodes, const SlamConfig& config,
                                     const LineOfSight& line_of_sight) {
  const std::size_t newest = T_W_nodes.size() - 1;
  const Eigen::Vector3d here = T_W_nodes[newest].translation();
  std::optional<std::size_t> best;
  double best_distance = config.closure_radius_m;
  for (std::size_t k = 0; k + static_cast<std::size_t>(config.min_closure_gap) < newest; ++k) {
    const double distance = (T_W_nodes[k].translation() - here).norm();
    if (distance >= best_distance || !line_of_sight(T_W_nodes[k].translation(), here)) continue;
    best = k;
    best_distance = distance;
  }
  return best;
}

/// Nodes that will be placed along the whole way.
std::size_t count_nodes(const Trajectory& truth, double spacing_m) {
  double length = 0.0;
  for (std::size_t k = 1; k < truth.poses.size(); ++k)
    length += (truth.poses[k].translation() - truth.poses[k - 1].translation()).norm();
  return static_cast<std::size_t>(length / spacing_m) + 1;
}

/// Deals out wrong loop closures so that they keep to their share of all.
class WrongClosures {
 public:
  WrongClosures(double share, Confidence confidence, RandomStream* random)
      : per_good_one_(share / (1.0 - share)),
        confidence_(confidence),
        random_(random),
        due_(share > 0.0 ? random->uniform() : 0.0) {}

  /// To be called at every good closure; adds a wrong one when it is due.
  void follow(const std::vector<Pose>& T_W_nodes, const SlamConfig& config,
              const Vector6d& closure_sigma, SlamRun* run) {
    due_ += per_good_one_;
    if (due_ < 1.0) return;
    const auto closure =
        make_wrong_closure(T_W_nodes, static_cast<std::size_t>(config.min_closure_gap),
                           closure_sigma, confidence_, random_);
    if (!closure) return;
    due_ -= 1.0;
    run->measurements.push_back(*closure);
    run->wrong_closures.push_back({closure->from, closure->to});
    ++run->loop_closures;
  }

 private:
  double per_good_one_;
  Confidence confidence_;
  RandomStream* random_;
  double due_;
};

}  // namespace

std::string format_g2o(const std::vector<SensorTime>& stamps, const std::vector<Pose>& T_M_nodes,
                       const std::vector<RelativeMeasurement>& measurements) {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  std::string text;
  text.reserve(200 * stamps.size() + 300 * measurements.size());
  for (std::size_t k = 0; k < T_M_nodes.size(); ++k) {
    text += "VERTEX_SE3:QUAT_TIME " + std::to_string(k);
    append_pose(T_M_nodes[k], &text);
    text += ' ' + std::to_string(stamps[k].ns / kNsPerSecond) + ' ' +
            std::to_string(stamps[k].ns % kNsPerSecond) + '\n';
  }
  for (const RelativeMeasurement& m : measurements) {
    text += "EDGE_SE3:QUAT " + std::to_string(m.from) + ' ' + std::to_string(m.to);
    append_pose(m.T_from_to, &text);
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        text += ' ';
        append_number(m.information(row, column), &text);
      }
    }
    text += '\n';
  }
  return text;
}

SlamRun run_slam(const Trajectory& truth, const Trajectory& odometry, const DriftConfig& drift,
                 const SlamConfig& config, const LineOfSight& line_of_sight, std::uint64_t seed) {
  Vector6d closure_sigma;
  closure_sigma << Eigen::Vector3d::Constant(config.closure_noise_m),
      Eigen::Vector3d::Constant(config.closure_noise_rad);
  RandomStream random = random_stream(seed, Purpose::kLoopClosures);
  RandomStream wrong_random = random_stream(seed, Purpose::kWrongClosures);
  WrongClosures doubtful(config.wrong_closures, Confidence::kDoubtful, &wrong_random);
  WrongClosures confident(config.confident_wrong_closures, Confidence::kConfident, &wrong_random);
  const LateShift late_shift(config.late_shift_m, count_nodes(truth, config.node_spacing_m));
  SlamRun run;
  std::vector<Pose> T_W_nodes;
  std::size_t last_sample = 0;
  std::size_t last_closure = 0;
  bool is_published = false;
  const auto publish = [&]() {
    const SensorTime stamp =
        run.node_stamps.back() + Duration::from_seconds(config.publish_delay_s);
    if (stamp > truth.end()) return;  // too late for this mission
    if (late_shift.is_unnoticed(run.T_M_nodes.size())) {
      const FaultyGraph graph = late_shift.apply(run.T_M_nodes, run.measurements);
      run.snapshots.push_back(
          {stamp, format_g2o(run.node_stamps, graph.T_M_nodes, graph.measurements)});
    } else {
      run.snapshots.push_back(
          {stamp, format_g2o(run.node_stamps, run.T_M_nodes, run.measurements)});
    }
    run.nodes_published = run.T_M_nodes.size();
    is_published = true;
  };

  double travelled = config.node_spacing_m;  // the first pose becomes a node at once
  for (std::size_t sample = 0; sample < truth.poses.size(); ++sample) {
    if (sample > 0)
      travelled +=
          (truth.poses[sample].translation() - truth.poses[sample - 1].translation()).norm();
    if (travelled < config.node_spacing_m) continue;
    const std::size_t node = T_W_nodes.size();
    T_W_nodes.push_back(truth.poses[sample]);
    run.node_stamps.push_back(truth.stamp(sample));
    if (node == 0) {
      run.T_M_nodes.push_back(truth.poses[sample]);
    } else {
      const Pose T_from_to = odometry.poses[last_sample].inverse() * odometry.poses[sample];
      run.T_M_nodes.push_back(run.T_M_nodes.back() * T_from_to);
      run.measurements.push_back(
          {node - 1, node, T_from_to, diagonal_information(odometry_sigma(drift, travelled))});
    }
    travelled = 0.0;
    last_sample = sample;

    std::optional<std::size_t> seen;
    if (node >= last_closure + static_cast<std::size_t>(config.min_closure_spacing)) {
      seen = recognise(T_W_nodes, config, line_of_sight);
    }
    if (seen) {
      Vector6d noise;
      for (int k = 0; k < 6; ++k) noise[k] = closure_sigma[k] * random.normal();
      run.measurements.push_back(
          {*seen, node, T_W_nodes[*seen].inverse() * T_W_nodes[node] * pose_from_tangent(noise),
           diagonal_information(closure_sigma)});
      ++run.loop_closures;
      last_closure = node;
      doubtful.follow(T_W_nodes, config, closure_sigma, &run);
      confident.follow(T_W_nodes, config, closure_sigma, &run);
      optimize_graph(run.measurements, &run.T_M_nodes);
    }
    is_published = false;
    if (seen || node % static_cast<std::size_t>(config.publish_every) == 0) publish();
  }
  if (!is_published) publish();
  return run;
}

}  // namespace cloister
