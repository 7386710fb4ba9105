#include "mapping/graph/relative_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include "mapping/graph/se3.hpp"

namespace cloister {
namespace {

/// The pose of seven numbers, x y z qx qy qz qw.
Pose read_pose(std::istream& in) {
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  in >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
  return make_pose(t, q);
}

/// Reads a well-formed file of the test data; the program's reader is tested where it lives.
PoseGraph read_graph(const std::string& name) {
  std::ifstream in(std::string(CLOISTER_TEST_DATA) + "/uncertainty/" + name + ".g2o");
  REQUIRE(in);
  PoseGraph graph;
  for (std::string line, tag; std::getline(in, line);) {
    std::istringstream fields(line);
    fields >> tag;
    if (tag == "VERTEX_SE3:QUAT") {
      GraphNode node;
      fields >> node.id;
      node.T_M_N = read_pose(fields);
      graph.nodes.push_back(node);
    } else {
      GraphEdge edge;
      fields >> edge.from >> edge.to;
      edge.T_from_to = read_pose(fields);
      for (int row = 0; row < 6; ++row) {
        for (int col = row; col < 6; ++col) {
          fields >> edge.information(row, col);
          edge.information(col, row) = edge.information(row, col);
        }
      }
      graph.edges.push_back(edge);
    }
  }
  std::sort(graph.nodes.begin(), graph.nodes.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  return graph;
}

/// One row of a reference file.
struct Reference {
  NodeId i = kNoNode;
  NodeId j = kNoNode;
  Matrix6d S;
  Eigen::Vector3d variances_m2;
};

std::vector<Reference> read_references(const std::string& file) {
  std::ifstream in(std::string(CLOISTER_TEST_DATA) + "/uncertainty/" + file);
  REQUIRE(in);
  std::vector<Reference> references;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#') || line.starts_with('i')) continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    Reference reference;
    fields >> reference.i >> reference.j;
    for (int k = 0; k < 36; ++k) fields >> reference.S(k / 6, k % 6);
    for (double& variance : reference.variances_m2) fields >> variance;
    REQUIRE(fields);
    references.push_back(reference);
  }
  return references;
}

void check_references(const std::string& name, ResidualJacobian jacobian, const std::string& file) {
  auto uncertainty = RelativeUncertainty::build(read_graph(name), jacobian);
  REQUIRE(uncertainty);
  for (const Reference& reference : read_references(file)) {
    CAPTURE(file);
    CAPTURE(reference.i);
    CAPTURE(reference.j);
    const std::optional<Matrix6d> S = uncertainty->covariance(reference.i, reference.j);
    REQUIRE(S);
    CHECK((*S - reference.S).norm() <= 1e-6 * reference.S.norm());
    const Vector6d sigma = reference.S.diagonal().cwiseSqrt();
    CHECK(((*S - reference.S).cwiseAbs().cwiseQuotient(sigma * sigma.transpose())).maxCoeff() <=
          1e-6);
    CHECK(*S == S->transpose());
    const Eigen::Vector3d variances_m2 = translational_variances_m2(*S);
    const Eigen::Vector3d sigma_m = *uncertainty->sigma_m(reference.i, reference.j);
    for (int k = 0; k < 3; ++k) {
      CHECK(std::abs(variances_m2[k] - reference.variances_m2[k]) <=
            1e-6 * reference.variances_m2[k]);
      CHECK(sigma_m[k] == std::sqrt(variances_m2[k]));
    }
  }
}

GraphEdge make_edge(NodeId from, NodeId to, const Pose& T_from_to, double information = 100.0) {
  GraphEdge edge;
  edge.from = from;
  edge.to = to;
  edge.T_from_to = T_from_to;
  edge.information = information * Matrix6d::Identity();
  return edge;
}

/// Nodes with the given ids, each 2 m and a slight turn past the one before, and no edges.
PoseGraph make_nodes(std::initializer_list<NodeId> ids) {
  Vector6d step;
  step << 2.0, 0.1, -0.05, 0.02, -0.01, 0.3;
  PoseGraph graph;
  Pose T_M_N = make_pose({5.0, -3.0, 1.0}, Eigen::Quaterniond(0.8, 0.1, -0.2, 0.4));
  for (const NodeId id : ids) {
    GraphNode node;
    node.id = id;
    node.T_M_N = T_M_N;
    graph.nodes.push_back(node);
    T_M_N = T_M_N * se3_exp(step);
  }
  return graph;
}

/// Joins two nodes by an edge that their poses satisfy exactly.
void join(PoseGraph& graph, NodeId from, NodeId to, double information = 100.0) {
  const Pose T_from_to =
      graph.nodes[graph.find(from)].T_M_N.inverse() * graph.nodes[graph.find(to)].T_M_N;
  graph.edges.push_back(make_edge(from, to, T_from_to, information));
}

int count_rejected(const std::string& name, const std::string& references) {
  constexpr double kMaxSigma_m = 0.2;
  auto uncertainty = RelativeUncertainty::build(read_graph(name));
  REQUIRE(uncertainty);
  int rejected = 0;
  for (const Reference& pair : read_references(references)) {
    if (uncertainty->sigma_m(pair.i, pair.j)->z() > kMaxSigma_m) ++rejected;
  }
  return rejected;
}

}  // namespace

TEST_CASE("covariances agree with the reference values under both conventions") {
  std::string name;
  SUBCASE("pose3example") { name = "pose3example"; }
  SUBCASE("corridor60") { name = "corridor60"; }
  SUBCASE("corridor60_open") { name = "corridor60_open"; }
  SUBCASE("building200") { name = "building200"; }
  SUBCASE("smallGrid3D") { name = "smallGrid3D"; }
  SUBCASE("parking-garage") { name = "parking-garage"; }
  check_references(name, ResidualJacobian::kGtsamDefault, name + "_relative.csv");
  check_references(name, ResidualJacobian::kExact, name + "_relative_exact.csv");
}

TEST_CASE("loop closures turn the corridor's refused pairs into accepted ones") {
  CHECK(count_rejected("corridor60_open", "corridor60_open_relative_exact.csv") == 45);
  CHECK(count_rejected("corridor60", "corridor60_relative_exact.csv") == 0);
  auto open = RelativeUncertainty::build(read_graph("corridor60_open"));
  auto closed = RelativeUncertainty::build(read_graph("corridor60"));
  CHECK(open->sigma_m(0, 57)->z() == doctest::Approx(0.352).epsilon(2e-3));
  CHECK(closed->sigma_m(0, 57)->z() == doctest::Approx(0.0225).epsilon(3e-3));
}

TEST_CASE("the other direction of a pair is the same covariance seen from the other node") {
  const PoseGraph graph = read_graph("building200");
  auto uncertainty = RelativeUncertainty::build(graph);
  REQUIRE(uncertainty);
  for (const auto& [i, j] : {std::pair<NodeId, NodeId>{0, 57}, {3, 150}, {199, 20}}) {
    const Pose T_i_j =
        graph.nodes[graph.find(i)].T_M_N.inverse() * graph.nodes[graph.find(j)].T_M_N;
    const Matrix6d Ad = se3_adjoint(T_i_j);
    const Matrix6d S_ij = *uncertainty->covariance(i, j);
    const Matrix6d S_ji = *uncertainty->covariance(j, i);
    CHECK(S_ji.isApprox(Ad * S_ij * Ad.transpose(), 1e-10));
    const Eigen::Vector3d larger = *uncertainty->larger_sigma_m(i, j);
    CHECK(larger == *uncertainty->larger_sigma_m(j, i));
    CHECK(larger[2] == std::max(uncertainty->sigma_m(i, j)->z(), uncertainty->sigma_m(j, i)->z()));
  }
}

TEST_CASE("the uncertainty of a chain is that of its edges carried to its end") {
  PoseGraph graph = make_nodes({10, 20, 35});
  join(graph, 10, 20, 100.0);
  join(graph, 20, 35, 400.0);
  auto uncertainty = RelativeUncertainty::build(graph);
  REQUIRE(uncertainty);
  const Matrix6d A = se3_adjoint(graph.nodes[2].T_M_N.inverse() * graph.nodes[1].T_M_N);
  const Matrix6d expected = A * A.transpose() / 100.0 + Matrix6d::Identity() / 400.0;
  CHECK(uncertainty->covariance(10, 35)->isApprox(expected, 1e-12));
  CHECK(uncertainty->covariance(10, 20)->isApprox(Matrix6d::Identity() / 100.0, 1e-12));
}

TEST_CASE("neither an edge's direction nor the order of edges matters, and parallel edges add up") {
  PoseGraph forward = make_nodes({1, 2, 3});
  join(forward, 1, 2, 300.0);
  join(forward, 2, 3, 100.0);
  PoseGraph mixed = make_nodes({1, 2, 3});
  join(mixed, 3, 2, 100.0);
  join(mixed, 1, 2, 100.0);
  join(mixed, 1, 2, 200.0);
  // Read backwards, the edge's information belongs to node 2's axes.
  const Matrix6d A = se3_adjoint(mixed.nodes[2].T_M_N.inverse() * mixed.nodes[1].T_M_N);
  mixed.edges[0].information = A.transpose() * (100.0 * Matrix6d::Identity()) * A;
  auto a = RelativeUncertainty::build(forward);
  auto b = RelativeUncertainty::build(mixed);
  REQUIRE(a);
  REQUIRE(b);
  for (const NodeId i : {1, 2, 3}) {
    for (const NodeId j : {1, 2, 3})
      CHECK((*a->covariance(i, j) - *b->covariance(i, j)).norm() < 1e-14);
  }
}

TEST_CASE("which node is held fixed does not matter") {
  PoseGraph graph = read_graph("corridor60");
  auto uncertainty = RelativeUncertainty::build(graph);
  for (GraphNode& node : graph.nodes) node.id = 100 - node.id;
  std::reverse(graph.nodes.begin(), graph.nodes.end());
  for (GraphEdge& edge : graph.edges) {
    edge.from = 100 - edge.from;
    edge.to = 100 - edge.to;
  }
  auto renamed = RelativeUncertainty::build(graph);
  REQUIRE(renamed);
  for (const auto& [i, j] : {std::pair<NodeId, NodeId>{0, 59}, {5, 31}, {40, 2}}) {
    CHECK(uncertainty->covariance(i, j)->isApprox(*renamed->covariance(100 - i, 100 - j), 1e-9));
  }
}

TEST_CASE("a node is certain of itself") {
  auto uncertainty = RelativeUncertainty::build(read_graph("corridor60"));
  CHECK(*uncertainty->covariance(0, 0) == Matrix6d::Zero());
  CHECK(*uncertainty->covariance(30, 30) == Matrix6d::Zero());
  CHECK(*uncertainty->larger_sigma_m(30, 30) == Eigen::Vector3d::Zero());
}

TEST_CASE("graphs without edges or without nodes have no answer but for a node and itself") {
  auto empty = RelativeUncertainty::build(PoseGraph{});
  REQUIRE(empty);
  CHECK_FALSE(empty->covariance(0, 0).has_value());
  auto single = RelativeUncertainty::build(make_nodes({7}));
  REQUIRE(single);
  CHECK(*single->covariance(7, 7) == Matrix6d::Zero());
  CHECK_FALSE(single->covariance(7, 8).has_value());
  CHECK_FALSE(single->sigma_m(8, 7).has_value());
  CHECK_FALSE(single->larger_sigma_m(8, 8).has_value());
}

TEST_CASE("nodes of separate components have no relative pose, those within one do") {
  PoseGraph graph = make_nodes({1, 2, 3, 4, 5});
  join(graph, 1, 3);
  join(graph, 4, 2);
  join(graph, 2, 5, 0.0);  // measures nothing
  auto uncertainty = RelativeUncertainty::build(graph);
  REQUIRE(uncertainty);
  CHECK(uncertainty->covariance(1, 3)->isApprox(Matrix6d::Identity() / 100.0, 1e-12));
  CHECK(uncertainty->covariance(4, 2)->isApprox(Matrix6d::Identity() / 100.0, 1e-12));
  CHECK_FALSE(uncertainty->covariance(1, 2).has_value());
  CHECK_FALSE(uncertainty->larger_sigma_m(3, 4).has_value());
  CHECK_FALSE(uncertainty->covariance(2, 5).has_value());
}

TEST_CASE("answers do not depend on what was asked before") {
  const PoseGraph graph = read_graph("parking-garage");
  auto fresh = RelativeUncertainty::build(graph);
  auto used = RelativeUncertainty::build(graph);
  REQUIRE(used);
  for (NodeId i = 0; i < 600; ++i)
    (void)used->covariance(i, 1660 - i);  // more nodes than the cache holds
  for (NodeId i = 0; i < 1600; i += 100)
    CHECK(*fresh->covariance(i, i + 37) == *used->covariance(i, i + 37));
}

TEST_CASE("a graph whose information is not positive definite is refused with the node's id") {
  PoseGraph graph = make_nodes({3, 4, 9});
  join(graph, 3, 4);
  join(graph, 4, 9);
  SUBCASE("indefinite") { graph.edges[1].information(5, 5) = -100.0; }
  SUBCASE("singular") { graph.edges[1].information.row(0).setZero(); }
  const auto uncertainty = RelativeUncertainty::build(graph);
  REQUIRE_FALSE(uncertainty);
  CHECK(uncertainty.error().kind == ErrorKind::kInput);
  CAPTURE(uncertainty.error().message);
  CHECK(uncertainty.error().message.find("singular or indefinite") != std::string::npos);
}

TEST_CASE("numbers that are not finite and edges without their nodes are refused by name") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PoseGraph graph = make_nodes({3, 4, 9});
  join(graph, 3, 4);
  join(graph, 4, 9);
  std::string expected = "edge 4 -> 9";
  SUBCASE("pose") {
    graph.nodes[2].T_M_N.translation().x() = kNan;
    expected = "node 9";
  }
  SUBCASE("measurement") { graph.edges[1].T_from_to.translation().x() = kNan; }
  SUBCASE("information") { graph.edges[1].information(2, 3) = kNan; }
  SUBCASE("unknown node") {
    graph.edges[1].to = 8;
    expected = "edge 4 -> 8";
  }
  SUBCASE("edge from a node to itself") {
    graph.edges[1].to = 4;
    expected = "edge 4 -> 4";
  }
  const auto uncertainty = RelativeUncertainty::build(graph);
  REQUIRE_FALSE(uncertainty);
  CHECK(uncertainty.error().message.find(expected) != std::string::npos);
}

}  // namespace cloister
