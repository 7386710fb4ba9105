#pragma once

#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/result.hpp"
#include "mapping/graph/block_cholesky.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// How an edge's residual e = Log(Z^-1 T_i^-1 T_j) is linearised, with T = mean * Exp(xi).
enum class ResidualJacobian {
  kExact,         ///< de/dxi_j = Jr^-1(e), de/dxi_i = -Jr^-1(e) Ad(T_ij^-1): the project's choice
  kGtsamDefault,  ///< the same without Jr^-1(e), as GTSAM's between-factor is built by default
};

/// How well the relative pose of two nodes is known, given one revision of a pose graph.
///
/// Problem: the covariance S_ij of xi in T_ij = T_i^-1 T_j = mean * Exp(xi), which is
///   S_ij = A S_ii A^T + S_jj - A S_ij - S_ij^T A^T,  A = Ad(T_ij^-1)
/// over the blocks of the joint marginal (Wang et al. 2021, appendix). Those can be a million times
/// larger than their difference. Solution: with the information matrix factored as L L^T under the
/// ordering P,
///   S_ij = W^T W,  W = L^-1 P [-A^T at i; I at j],
/// symmetric and positive semidefinite by construction. W is put together from one sparse solve per
/// node, kept for the pairs that follow: F_n = L^-1 P [Ad(T_n)^T at n] with T_n seen from the
/// anchor gives W = (F_j - F_i) Ad(T_j^-1)^T.
///
/// The graph is linearised at its poses as they stand. In each connected component the node with
/// the smallest id is held fixed, that is, taken out of the unknowns; S_ij does not depend on
/// which. Edges whose information is all zero measure nothing and connect nothing. Any new edge
/// changes every pair: build anew for each revision.
///
/// Threads: one at a time (queries fill a cache). Memory: allocates; a few hundred bytes per block
/// of the factor.
class RelativeUncertainty {
 public:
  /// Assembles and factors. About 1 ms per 200 nodes in a graph with loops.
  /// @return kInput with the node's or edge's ids when a pose, a measurement or an information
  ///         matrix is not finite, when an edge does not join two nodes of the graph, or when the
  ///         information is singular or indefinite
  [[nodiscard]] static Result<RelativeUncertainty> build(
      const PoseGraph& graph, ResidualJacobian jacobian = ResidualJacobian::kExact);

  /// S_ij: over (translation [m], rotation vector [rad]), in the axes of node j; zero for i == j.
  /// S_ji is another matrix, Ad(T_ij) S_ij Ad(T_ij)^T, because node i's orientation error acts over
  /// the distance.
  /// @return nothing when a node is unknown, or no chain of edges joins the two
  [[nodiscard]] std::optional<Matrix6d> covariance(NodeId i, NodeId j);

  /// Standard deviations [m] along the principal axes of S_ij's translational block, ascending.
  [[nodiscard]] std::optional<Eigen::Vector3d> sigma_m(NodeId i, NodeId j);

  /// For decisions: sigma_m(i, j) or sigma_m(j, i), whichever has the larger maximum. Exactly the
  /// same for (i, j) and (j, i). A pair is too uncertain when the last entry exceeds
  /// FusionConfig::max_sigma_m.
  [[nodiscard]] std::optional<Eigen::Vector3d> larger_sigma_m(NodeId i, NodeId j);

 private:
  struct Node {
    Pose T_anchor_N = Pose::Identity();
    int component = 0;  ///< equal for nodes that edges join
    int unknown = -1;   ///< block of the information matrix; -1 for an anchor
  };

  RelativeUncertainty(std::unordered_map<NodeId, Node> nodes, BlockCholesky factor)
      : nodes_(std::move(nodes)), factor_(std::move(factor)) {}

  /// Two nodes that edges join.
  struct Pair {
    const Node& i;
    const Node& j;
  };
  [[nodiscard]] std::optional<Pair> find(NodeId i, NodeId j) const;
  const BlockCholesky::Column& column(const Node& node);
  Matrix6d spread(const Node& node_i, const Node& node_j);

  std::unordered_map<NodeId, Node> nodes_;
  BlockCholesky factor_;
  std::unordered_map<int, BlockCholesky::Column> columns_;  ///< F_n^T by unknown: the cache
};

/// Eigenvalues [m^2] of the translational block of a covariance, ascending, not below zero.
[[nodiscard]] Eigen::Vector3d translational_variances_m2(const Matrix6d& covariance);

}  // namespace cloister
