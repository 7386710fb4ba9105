#include "mapping/graph/relative_uncertainty.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "mapping/graph/se3.hpp"

namespace cloister {
namespace {

/// Bounds the cache when all pairs of a large graph are asked for: 256 columns of a path of 300
/// blocks are 22 MB.
constexpr std::size_t kMaxColumns = 256;

/// An edge with the places of its nodes in the graph.
struct Link {
  const GraphEdge* edge;
  int from;
  int to;
};

std::string name(const GraphEdge& edge) {
  return "edge " + std::to_string(edge.from) + " -> " + std::to_string(edge.to);
}

Result<std::vector<Link>> find_links(const PoseGraph& graph) {
  for (const GraphNode& node : graph.nodes) {
    if (!is_finite(node.T_M_N)) {
      return fail(ErrorKind::kInput, "pose graph: the pose of node " + std::to_string(node.id) +
                                         " is not finite: leave this revision out");
    }
  }
  std::vector<Link> links;
  links.reserve(graph.edges.size());
  for (const GraphEdge& edge : graph.edges) {
    const int from = static_cast<int>(graph.find(edge.from));
    const int to = static_cast<int>(graph.find(edge.to));
    if (from < 0 || to < 0 || from == to) {
      return fail(ErrorKind::kInput,
                  "pose graph: " + name(edge) + " does not join two nodes of the graph: remove it");
    }
    if (!is_finite(edge.T_from_to) || !edge.information.allFinite()) {
      return fail(ErrorKind::kInput,
                  "pose graph: the measurement of " + name(edge) + " is not finite: remove it");
    }
    if (!edge.information.isZero(0.0)) links.push_back({&edge, from, to});
  }
  return links;
}

/// For each node the smallest place in its connected component: its anchor, since nodes are sorted
/// by id.
std::vector<int> find_anchors(std::size_t num_nodes, const std::vector<Link>& links) {
  std::vector<int> parent(num_nodes);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (const Link& link : links) {
    const auto [smaller, larger] = std::minmax({root(link.from), root(link.to)});
    parent[larger] = smaller;
  }
  for (int node = 0; node < static_cast<int>(num_nodes); ++node) parent[node] = root(node);
  return parent;
}

/// A covariance over the anchor's axes, carried into a node's: Ad(T_N_anchor) D Ad(T_N_anchor)^T.
Matrix6d in_axes_of(const Pose& T_anchor_N, const Matrix6d& D) {
  const Matrix6d adjoint = se3_adjoint(T_anchor_N.inverse());
  const Matrix6d S = adjoint * D * adjoint.transpose();
  return 0.5 * (S + S.transpose());
}

Eigen::Vector3d sigma_of(const Matrix6d& covariance) {
  return translational_variances_m2(covariance).cwiseSqrt();
}

}  // namespace

Result<RelativeUncertainty> RelativeUncertainty::build(const PoseGraph& graph,
                                                       ResidualJacobian jacobian) {
  const Result<std::vector<Link>> links = find_links(graph);
  if (!links) return tl::unexpected(links.error());

  const std::vector<int> anchors = find_anchors(graph.nodes.size(), *links);
  std::vector<int> unknowns(graph.nodes.size(), -1);
  std::vector<NodeId> ids;  // of the unknowns
  std::unordered_map<NodeId, Node> nodes;
  nodes.reserve(graph.nodes.size());
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (anchors[n] != static_cast<int>(n)) {
      unknowns[n] = static_cast<int>(ids.size());
      ids.push_back(graph.nodes[n].id);
    }
    const Pose& T_M_anchor = graph.nodes[anchors[n]].T_M_N;
    nodes[graph.nodes[n].id] = {T_M_anchor.inverse() * graph.nodes[n].T_M_N, anchors[n],
                                unknowns[n]};
  }

  std::vector<BlockCholesky::Position> positions;
  positions.reserve(links->size());
  for (const Link& link : *links) {
    if (unknowns[link.from] >= 0 && unknowns[link.to] >= 0) {
      positions.emplace_back(unknowns[link.from], unknowns[link.to]);
    }
  }
  BlockCholesky factor(static_cast<int>(ids.size()), positions);
  for (const Link& link : *links) {
    const Pose T_i_j = graph.nodes[link.from].T_M_N.inverse() * graph.nodes[link.to].T_M_N;
    const Matrix6d A = se3_adjoint(T_i_j.inverse());
    Matrix6d information = link.edge->information;
    if (jacobian == ResidualJacobian::kExact) {
      const Vector6d residual = se3_log(link.edge->T_from_to.inverse() * T_i_j);
      const Matrix6d Jr_inverse = se3_inverse_right_jacobian(residual);
      information = Jr_inverse.transpose() * information * Jr_inverse;
    }
    const Matrix6d At_information = A.transpose() * information;
    const int i = unknowns[link.from];
    const int j = unknowns[link.to];
    if (i >= 0) factor.add_diagonal(i, At_information * A);
    if (j >= 0) factor.add_diagonal(j, information);
    if (i >= 0 && j >= 0) factor.add_off_diagonal(i, j, -At_information);
  }
  if (const std::optional<int> stopped = factor.factor()) {
    return fail(ErrorKind::kInput,
                "pose graph: the information is singular or indefinite around node " +
                    std::to_string(ids[*stopped]) +
                    ": check the information matrices of its edges");
  }
  return RelativeUncertainty(std::move(nodes), std::move(factor));
}

std::optional<RelativeUncertainty::Pair> RelativeUncertainty::find(NodeId i, NodeId j) const {
  const auto it_i = nodes_.find(i);
  const auto it_j = nodes_.find(j);
  if (it_i == nodes_.end() || it_j == nodes_.end()) return std::nullopt;
  if (it_i->second.component != it_j->second.component) return std::nullopt;
  return Pair{it_i->second, it_j->second};
}

const BlockCholesky::Column& RelativeUncertainty::column(const Node& node) {
  const auto [it, is_new] = columns_.try_emplace(node.unknown);
  if (is_new && node.unknown >= 0) {
    it->second = factor_.solve_unit(node.unknown);
    const Matrix6d adjoint = se3_adjoint(node.T_anchor_N);
    for (Matrix6d& block : it->second.blocks) block = (adjoint * block.transpose()).eval();
  }
  return it->second;
}

/// (F_j - F_i)^T (F_j - F_i): the covariance, still in the axes of the anchor.
Matrix6d RelativeUncertainty::spread(const Node& node_i, const Node& node_j) {
  // Room is made before, since neither column may go while the other is fetched.
  if (columns_.size() + 2 > kMaxColumns) columns_.clear();
  const BlockCholesky::Column& F_i = column(node_i);
  const BlockCholesky::Column& F_j = column(node_j);
  // A sum over the union of both paths through the elimination tree.
  Matrix6d D = Matrix6d::Zero();
  std::size_t p = 0;
  std::size_t q = 0;
  Matrix6d difference;
  while (p < F_i.rows.size() || q < F_j.rows.size()) {
    const bool in_i = p < F_i.rows.size() && (q == F_j.rows.size() || F_i.rows[p] <= F_j.rows[q]);
    const bool in_j = q < F_j.rows.size() && (p == F_i.rows.size() || F_j.rows[q] <= F_i.rows[p]);
    if (in_i && in_j) {
      difference = F_j.blocks[q] - F_i.blocks[p];
    } else {
      difference = in_i ? F_i.blocks[p] : F_j.blocks[q];  // squared below: the sign does not matter
    }
    p += in_i ? 1 : 0;
    q += in_j ? 1 : 0;
    D.noalias() += difference * difference.transpose();
  }
  return D;
}

std::optional<Matrix6d> RelativeUncertainty::covariance(NodeId i, NodeId j) {
  const std::optional<Pair> pair = find(i, j);
  if (!pair) return std::nullopt;
  return in_axes_of(pair->j.T_anchor_N, spread(pair->i, pair->j));
}

std::optional<Eigen::Vector3d> RelativeUncertainty::sigma_m(NodeId i, NodeId j) {
  const std::optional<Matrix6d> S_ij = covariance(i, j);
  if (!S_ij) return std::nullopt;
  return sigma_of(*S_ij);
}

std::optional<Eigen::Vector3d> RelativeUncertainty::larger_sigma_m(NodeId i, NodeId j) {
  const std::optional<Pair> pair = find(std::min(i, j), std::max(i, j));
  if (!pair) return std::nullopt;
  const Matrix6d D = spread(pair->i, pair->j);
  const Eigen::Vector3d forward = sigma_of(in_axes_of(pair->j.T_anchor_N, D));
  const Eigen::Vector3d backward = sigma_of(in_axes_of(pair->i.T_anchor_N, D));
  return forward.z() >= backward.z() ? forward : backward;
}

Eigen::Vector3d translational_variances_m2(const Matrix6d& covariance) {
  const Eigen::Matrix3d block = covariance.topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0);
}

}  // namespace cloister
