#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "mapping/core/pose.hpp"
#include "mapping/graph/graph_revision.hpp"

namespace cloister {

/// The nodes whose scans a submap holds, each where it was in the submap when its first scan came: what binds the submap to
/// the pose graph. A thinned list of fixed capacity: when it is full every second one goes, but never the first, and every
/// second new one is taken from then on.
///
/// Threads: as its submap. No allocation.
class SubmapAnchors {
 public:
  static constexpr std::size_t kCapacity = 64;

  void clear() { *this = {}; }

  /// Notes a node, unless it is the one noted last, or kNoNode.
  /// @param T_N_S  the submap's pose in the node's frame
  void add(NodeId node, const Pose& T_N_S);
  /// Takes over the anchors of a submap that is fused into this one.
  void add(const SubmapAnchors& other, const Pose& T_other_S);

  /// The submap's frame becomes another one. @param T_S_new  its pose in the frame so far
  void move_frame(const Pose& T_S_new);

  /// Where a revision has the submap. A graph that bends moves a submap's nodes against each other, which the submap
  /// cannot follow; its pose is then the rigid one that leaves most of its nodes where the graph has them. In turn: the
  /// minimum of sum w (|p_M - T_M_S p_S|^2 + l^2 |R_M - R_M_S R_S|^2) over the nodes' positions p and rotations R, in closed
  /// form (Umeyama 1991, without scale); and weights w (Geman and McClure's, of a node's shift and l times its turn) that
  /// let go of nodes that a wrong loop closure has torn away. Nodes that the revision does not have, or has nowhere (see
  /// is_place), are left out.
  /// @return nothing when the revision has none of them; exactly what the first node says when all say the same
  [[nodiscard]] std::optional<Pose> fit(const GraphRevision& revision) const;

 private:
  struct Anchor {
    NodeId node = kNoNode;
    Eigen::Vector3d t_N_S = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q_N_S = Eigen::Quaterniond::Identity();
  };

  std::array<Anchor, kCapacity> anchors_;
  std::size_t size_ = 0;
  std::size_t stride_ = 1;   ///< of so many new nodes one is taken
  std::size_t skipped_ = 0;  ///< new nodes since the last one taken
  NodeId newest_ = kNoNode;
};

}  // namespace cloister
