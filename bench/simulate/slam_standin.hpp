#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/simulate/graph_optimizer.hpp"
#include "bench/simulate/odometry.hpp"
#include "bench/simulate/trajectory.hpp"

namespace cloister {

/// Stands in for the SLAM system that publishes pose graphs.
struct SlamConfig {
  double node_spacing_m = 2.0;        ///< of travel
  double closure_radius_m = 3.5;      ///< an older node this close may be recognised
  int min_closure_gap = 15;           ///< nodes between the two ends of a loop closure
  int min_closure_spacing = 3;        ///< nodes between two loop closures
  double closure_noise_m = 0.015;     ///< standard deviation per axis of a closure's translation
  double closure_noise_rad = 0.0035;  ///< and of its rotation
  int publish_every = 2;          ///< nodes per snapshot; every loop closure is published besides
  double publish_delay_s = 0.15;  ///< from a node's stamp to the snapshot that first holds it

  double wrong_closures = 0.0;            ///< share of loop closures that are wrong and admit doubt
  double confident_wrong_closures = 0.0;  ///< share that are wrong and look as good as the others
  double late_shift_m = 0.0;  ///< how far the old half of the nodes moves late; see LateShift
};

/// The whole graph as published once.
struct GraphSnapshot {
  SensorTime stamp;
  std::string g2o;  ///< the file's text
};

/// What the SLAM system did over a mission.
struct SlamRun {
  std::vector<GraphSnapshot> snapshots;
  std::vector<SensorTime> node_stamps;
  std::size_t nodes_published = 0;  ///< that the last snapshot has
  std::vector<Pose> T_M_nodes;  ///< as estimated at the end
  std::vector<RelativeMeasurement> measurements;
  int loop_closures = 0;
  std::vector<std::array<std::size_t, 2>> wrong_closures;  ///< their nodes, older first
};

/// True when nothing stands between two points of the world.
using LineOfSight = std::function<bool(const Eigen::Vector3d& a_W, const Eigen::Vector3d& b_W)>;

/// Places nodes along the truth, chains them by odometry, recognises places seen before, and
/// optimises the graph at every loop closure. The map frame is the world's: node 0 is held at its
/// true pose.
/// @param truth T_W_L @param odometry T_O_L with the same stamps @param drift what odometry's
/// information is made of
[[nodiscard]] SlamRun run_slam(const Trajectory& truth, const Trajectory& odometry,
                               const DriftConfig& drift, const SlamConfig& config,
                               const LineOfSight& line_of_sight, std::uint64_t seed);

/// The graph in g2o text: VERTEX_SE3:QUAT_TIME and EDGE_SE3:QUAT lines.
[[nodiscard]] std::string format_g2o(const std::vector<SensorTime>& stamps,
                                     const std::vector<Pose>& T_M_nodes,
                                     const std::vector<RelativeMeasurement>& measurements);

}  // namespace cloister
