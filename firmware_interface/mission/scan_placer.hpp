#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "firmware_interface/files/odometry_buffer.hpp"
#include "mapping/core/config.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// Gives scans their poses, and graph revisions what odometry says about their nodes; the same for recorded missions
/// and live ones.
///
/// A scan is placed by odometry, against a graph node whose own odometry is known: the newest that is not younger than
/// the scan, else the oldest; in O while there is none. A cloud with the very stamp of a node is placed by that node.
///
/// Odometry may begin anew, in a frame that has nothing to do with the one before. Nodes from before then no longer
/// serve as references, and once there has been a graph, scans cannot be placed until a younger node is known.
///
/// Threads: one at a time. Allocates when a graph comes.
class ScanPlacer {
 public:
  /// What became of a scan, in the order a caller can do something about it.
  enum class Placement {
    kPlaced,
    kTooLate,   ///< odometry does not reach it: a sample may still come
    kUntied,    ///< odometry has begun anew, and no node ties it to the map yet
    kTooEarly,  ///< taken before the first sample
    kGap,       ///< the samples around it lie too far apart
  };

  static constexpr std::size_t kMaxPoses = 256;

  ScanPlacer() = default;
  /// @param T_B_L  the sensor in the frame whose poses odometry and graph hold
  ScanPlacer(const ScanConfig& config, const Pose& T_B_L) : config_(config), T_B_L_(T_B_L) {}

  /// Before the first scan is placed.
  void set_T_B_L(const Pose& T_B_L) { T_B_L_ = T_B_L; }

  [[nodiscard]] OdometryBuffer& odometry() { return odometry_; }
  [[nodiscard]] const OdometryBuffer& odometry() const { return odometry_; }
  /// Forgets all odometry: what comes next is in another frame.
  void restart_odometry();

  /// Completes a revision: odometry at its nodes, and which of its loop closures are new. Its nodes serve from now on.
  void complete(GraphRevision& revision);

  /// Where the present odometry frame lies: by the newest node whose odometry is known. Identity while there was no
  /// graph; nothing when odometry has begun anew since.
  [[nodiscard]] const std::optional<Pose>& T_M_O() const { return T_M_O_; }

  /// Fills node, poses and T_O_L. A scan that is not placed keeps none of them.
  [[nodiscard]] Placement place(Scan& scan) const;

 private:
  struct KnownNode {
    SensorTime stamp;
    NodeId id = kNoNode;
    std::optional<Pose> T_O_N;  ///< in the present odometry frame
  };
  struct NodeOdometry {
    SensorTime stamp;
    Pose T_O_N = Pose::Identity();
    int frame = 0;
  };

  [[nodiscard]] OdometryBuffer::Limits limits() const;
  [[nodiscard]] bool place_by_node(Scan& scan) const;

  ScanConfig config_;
  Pose T_B_L_ = Pose::Identity();
  OdometryBuffer odometry_;
  int odometry_frame_ = 0;  ///< counts how often odometry has begun anew
  bool has_graph_ = false;
  std::optional<Pose> T_M_O_ = Pose::Identity();
  std::vector<KnownNode> nodes_;  ///< of the newest revision, by stamp
  /// Odometry is forgotten in time, nodes come again with every revision.
  std::unordered_map<NodeId, NodeOdometry> node_odometry_;
  std::set<std::pair<NodeId, NodeId>> known_loops_;
};

/// Returns in a scan, whatever their range.
[[nodiscard]] std::int64_t num_returns(const Scan& scan);

}  // namespace cloister
