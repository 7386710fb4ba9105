#include "mapping/submap/submap_anchors.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/SVD>

namespace cloister {
namespace {

// Nodes that say the same to this have not been moved against each other.
constexpr double kSameM = 1e-6;
// How far from the others a node counts half, as the fit goes on: from all of them to those that agree.
constexpr double kScalesM[] = {2, 1, 0.5, 0.25, 0.25, 0.25};

/// One node: in the submap, and where the revision has it.
struct NodePair {
  Pose T_S_N = Pose::Identity();
  Pose T_M_N = Pose::Identity();
  double weight = 1;
};

/// How far a node lies from where the submap's pose would have it.
double distance_m(const Pose& T_M_S, const NodePair& pair) {
  return displacement_m(pair.T_M_N.inverse() * T_M_S * pair.T_S_N);
}

/// The closed form for given weights.
Pose fit_weighted(std::span<const NodePair> pairs) {
  double sum = 0;
  Eigen::Vector3d middle_S = Eigen::Vector3d::Zero(), middle_M = Eigen::Vector3d::Zero();
  for (const NodePair& pair : pairs) {
    sum += pair.weight;
    middle_S += pair.weight * pair.T_S_N.translation();
    middle_M += pair.weight * pair.T_M_N.translation();
  }
  middle_S /= sum;
  middle_M /= sum;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const NodePair& pair : pairs) {
    covariance +=
        pair.weight *
        ((pair.T_M_N.translation() - middle_M) * (pair.T_S_N.translation() - middle_S).transpose() +
         kLeverM * kLeverM * pair.T_M_N.linear() * pair.T_S_N.linear().transpose());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if (U.determinant() * svd.matrixV().determinant() < 0) U.col(2) = -U.col(2);
  Pose T_M_S = Pose::Identity();
  T_M_S.linear() = U * svd.matrixV().transpose();
  T_M_S.translation() = middle_M - T_M_S.linear() * middle_S;
  return T_M_S;
}

}  // namespace

void SubmapAnchors::add(NodeId node, const Pose& T_N_S) {
  if (node == kNoNode || node == newest_) return;
  newest_ = node;
  if (++skipped_ < stride_ && size_ > 0) return;
  skipped_ = 0;
  if (size_ == kCapacity) {
    for (std::size_t i = 0; i < kCapacity / 2; ++i) anchors_[i] = anchors_[2 * i];
    size_ = kCapacity / 2;
    stride_ *= 2;
  }
  anchors_[size_++] = {node, T_N_S.translation(), Eigen::Quaterniond(T_N_S.linear())};
}

void SubmapAnchors::add(const SubmapAnchors& other, const Pose& T_other_S) {
  for (std::size_t i = 0; i < other.size_; ++i) {
    const Anchor& anchor = other.anchors_[i];
    add(anchor.node, make_pose(anchor.t_N_S, anchor.q_N_S) * T_other_S);
  }
}

void SubmapAnchors::move_frame(const Pose& T_S_new) {
  for (std::size_t i = 0; i < size_; ++i) {
    Anchor& anchor = anchors_[i];
    anchor.t_N_S += anchor.q_N_S * T_S_new.translation();
    anchor.q_N_S = anchor.q_N_S * Eigen::Quaterniond(T_S_new.linear());
  }
}

std::optional<Pose> SubmapAnchors::fit(const GraphRevision& revision) const {
  std::array<NodePair, kCapacity> pairs;
  std::size_t num_pairs = 0;
  bool is_same = true;
  Pose T_M_S = Pose::Identity();
  for (std::size_t i = 0; i < size_; ++i) {
    const GraphNode* node = revision.node(anchors_[i].node);
    if (node == nullptr || !is_place(node->T_M_N)) continue;
    const Pose T_N_S = make_pose(anchors_[i].t_N_S, anchors_[i].q_N_S);
    if (num_pairs == 0) T_M_S = node->T_M_N * T_N_S;
    pairs[num_pairs] = {T_N_S.inverse(), node->T_M_N};
    is_same = is_same && distance_m(T_M_S, pairs[num_pairs]) < kSameM;
    ++num_pairs;
  }
  if (num_pairs == 0) return std::nullopt;
  if (is_same) return T_M_S;
  const std::span<NodePair> all(pairs.data(), num_pairs);
  T_M_S = fit_weighted(all);
  for (const double scale_m : kScalesM) {
    for (NodePair& pair : all) {
      const double relative = distance_m(T_M_S, pair) / scale_m;
      pair.weight = 1 / ((1 + relative * relative) * (1 + relative * relative));
    }
    T_M_S = fit_weighted(all);
  }
  return T_M_S;
}

}  // namespace cloister
