#include "mapping/submap/submap_anchors.hpp"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

namespace cloister {
namespace {

/// A walk of 2 m a node, with a turn to the left at each.
Pose pose_of_node(NodeId id) {
  Pose T_M_N(Eigen::AngleAxisd(0.1 * static_cast<double>(id), Eigen::Vector3d::UnitZ()));
  T_M_N.translation() =
      Eigen::Vector3d{2.0 * static_cast<double>(id), 0.1 * static_cast<double>(id * id), 0};
  return T_M_N;
}

GraphRevision walk(NodeId num_nodes) {
  GraphRevision revision;
  for (NodeId id = 0; id < num_nodes; ++id) {
    revision.graph.nodes.push_back({id, {id * 1'000'000'000}, true, pose_of_node(id)});
    revision.T_O_N.emplace_back();
  }
  return revision;
}

/// The anchors of a submap with its frame at a place in M.
SubmapAnchors anchored(const GraphRevision& revision, const Pose& T_M_S) {
  SubmapAnchors anchors;
  for (const GraphNode& node : revision.graph.nodes)
    anchors.add(node.id, node.T_M_N.inverse() * T_M_S);
  return anchors;
}

Pose some_pose() {
  Pose T(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.2, -0.1, 1).normalized()));
  T.translation() = Eigen::Vector3d(4, -3, 1);
  return T;
}

double difference(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

TEST_CASE("a graph that moves as a whole moves a submap alike") {
  GraphRevision revision = walk(8);
  const SubmapAnchors anchors = anchored(revision, some_pose());
  const Pose T = some_pose() * some_pose();
  for (GraphNode& node : revision.graph.nodes) node.T_M_N = T * node.T_M_N;
  const auto T_M_S = anchors.fit(revision);
  REQUIRE(T_M_S);
  CHECK(difference(*T_M_S, T * some_pose()) < 1e-9);
}

TEST_CASE("what all nodes say is said by the first, to the bit") {
  const GraphRevision revision = walk(8);
  const SubmapAnchors all = anchored(revision, some_pose());
  SubmapAnchors first;
  first.add(0, pose_of_node(0).inverse() * some_pose());
  CHECK(all.fit(revision)->matrix() == first.fit(revision)->matrix());
}

TEST_CASE("a graph that bends leaves a submap in the middle of its nodes") {
  GraphRevision revision = walk(9);
  const SubmapAnchors anchors = anchored(revision, Pose::Identity());
  // The ends go up by 0.1 m, the middle goes down by as much.
  for (const NodeId id : {0, 1, 7, 8})
    revision.graph.nodes[static_cast<std::size_t>(id)].T_M_N.translation().z() += 0.1;
  for (const NodeId id : {3, 4, 5})
    revision.graph.nodes[static_cast<std::size_t>(id)].T_M_N.translation().z() -= 0.1;
  const Pose T_M_S = *anchors.fit(revision);
  CHECK(std::abs((T_M_S * pose_of_node(4).translation()).z()) < 0.05);
  CHECK(std::abs((T_M_S * pose_of_node(0).translation()).z()) < 0.05);
}

TEST_CASE("nodes that are torn away are let go, the root among them") {
  GraphRevision revision = walk(9);
  const SubmapAnchors anchors = anchored(revision, some_pose());
  for (const std::size_t torn : {0U, 1U, 5U})
    revision.graph.nodes[torn].T_M_N.translation().x() += 3;
  CHECK(difference(*anchors.fit(revision), some_pose()) < 0.02);
}

TEST_CASE("nodes that a revision does not have are left out; without any there is nothing to say") {
  GraphRevision revision = walk(9);
  const SubmapAnchors anchors = anchored(revision, some_pose());
  revision.graph.nodes.erase(revision.graph.nodes.begin(), revision.graph.nodes.begin() + 4);
  CHECK(difference(*anchors.fit(revision), some_pose()) < 1e-9);
  revision.graph.nodes.clear();
  CHECK_FALSE(anchors.fit(revision));
  CHECK_FALSE(SubmapAnchors().fit(walk(3)));
}

TEST_CASE("nodes that have diverged are left out") {
  for (const double nowhere : {1e300, std::numeric_limits<double>::quiet_NaN(), 1e10}) {
    GraphRevision revision = walk(9);
    const SubmapAnchors anchors = anchored(revision, some_pose());
    revision.graph.nodes[0].T_M_N.translation().y() = nowhere;
    revision.graph.nodes[5].T_M_N.translation().x() = -nowhere;
    const auto T_M_S = anchors.fit(revision);
    REQUIRE(T_M_S);
    CHECK(difference(*T_M_S, some_pose()) < 1e-9);
  }
}

TEST_CASE("a long submap is held by nodes from all of it, the root among them") {
  const NodeId many = 10 * static_cast<NodeId>(SubmapAnchors::kCapacity);
  GraphRevision revision = walk(many);
  const SubmapAnchors anchors = anchored(revision, some_pose());
  GraphRevision only = revision;
  only.graph.nodes.resize(1);
  CHECK(anchors.fit(only));
  only.graph.nodes.assign(revision.graph.nodes.end() - 40, revision.graph.nodes.end());
  CHECK(anchors.fit(only));
  // Of a submap that is fused into another, the nodes go on to hold the two of them.
  SubmapAnchors fused;
  fused.add(anchors, Pose::Identity());
  CHECK(difference(*fused.fit(revision), some_pose()) < 1e-9);
}

}  // namespace
}  // namespace cloister
