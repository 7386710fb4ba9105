#include "firmware_interface/mission/scan_placer.hpp"

#include <algorithm>
#include <cstdlib>

namespace cloister {
namespace {

// A cloud belongs to the node of its stamp; tools that write stamps as doubles miss by some 100 ns.
constexpr std::int64_t kSameStampNs = 1'000'000;

/// When the first of the scan's columns was measured.
SensorTime begin_of(const Scan& scan) {
  SensorTime begin = scan.stamp;
  if (scan.kind == Scan::Kind::kOrganised) {
    for (std::size_t column = 0; column < scan.column_valid.size(); ++column) {
      if (scan.column_valid[column]) begin = std::min(begin, scan.column_stamps[column]);
    }
  }
  return begin;
}

}  // namespace

OdometryBuffer::Limits ScanPlacer::limits() const {
  return {Duration::from_seconds(config_.max_odometry_gap_s),
          Duration::from_seconds(config_.max_odometry_wait_s)};
}

void ScanPlacer::restart_odometry() {
  odometry_ = OdometryBuffer();
  ++odometry_frame_;
  for (KnownNode& node : nodes_) node.T_O_N.reset();
  T_M_O_.reset();
}

void ScanPlacer::complete(GraphRevision& revision) {
  has_graph_ = true;
  nodes_.clear();
  SensorTime newest;
  revision.T_O_N.clear();
  for (const GraphNode& node : revision.graph.nodes) {
    auto known = node_odometry_.find(node.id);
    if (known == node_odometry_.end() || known->second.stamp != node.stamp) {
      if (const auto T_O_N = odometry_.at(node.stamp, limits())) {
        known = node_odometry_
                    .insert_or_assign(node.id, NodeOdometry{node.stamp, *T_O_N, odometry_frame_})
                    .first;
      } else {
        known = node_odometry_.end();
      }
    }
    const auto T_O_N_in = [&](int frame) {
      const bool is_known = known != node_odometry_.end() && known->second.frame == frame;
      return is_known ? std::optional(known->second.T_O_N) : std::nullopt;
    };
    // What was mapped before the first graph lies in the first frame.
    revision.T_O_N.push_back(T_O_N_in(0));
    nodes_.push_back({node.stamp, node.id, T_O_N_in(odometry_frame_)});
    if (const auto& T_O_N = nodes_.back().T_O_N; T_O_N && node.stamp >= newest) {
      newest = node.stamp;
      T_M_O_ = node.T_M_N * T_O_N->inverse();
    }
  }
  std::stable_sort(nodes_.begin(), nodes_.end(),
                   [](const KnownNode& a, const KnownNode& b) { return a.stamp < b.stamp; });
  revision.new_loops.clear();
  for (std::size_t i = 0; i < revision.graph.edges.size(); ++i) {
    const GraphEdge& edge = revision.graph.edges[i];
    if (edge.is_loop_closure() && known_loops_.insert(std::minmax(edge.from, edge.to)).second) {
      revision.new_loops.push_back(i);
    }
  }
}

bool ScanPlacer::place_by_node(Scan& scan) const {
  if (scan.kind != Scan::Kind::kCloud) return false;
  const auto it =
      std::lower_bound(nodes_.begin(), nodes_.end(), SensorTime{scan.stamp.ns - kSameStampNs},
                       [](const KnownNode& node, SensorTime stamp) { return node.stamp < stamp; });
  if (it == nodes_.end() || std::abs((it->stamp - scan.stamp).ns) > kSameStampNs) return false;
  scan.node = it->id;
  scan.poses.assign(1, {scan.stamp, T_B_L_});
  scan.T_O_L.reset();
  if (it->T_O_N) scan.T_O_L = *it->T_O_N * T_B_L_;
  return true;
}

ScanPlacer::Placement ScanPlacer::place(Scan& scan) const {
  if (place_by_node(scan)) return Placement::kPlaced;
  const auto is_known = [](const KnownNode& node) { return node.T_O_N.has_value(); };
  if (odometry_frame_ > 0 && has_graph_ && std::none_of(nodes_.begin(), nodes_.end(), is_known)) {
    return Placement::kUntied;
  }
  switch (odometry_.cover(begin_of(scan), scan.stamp, limits(), kMaxPoses, scan.poses)) {
    case OdometryBuffer::Coverage::kCovered:
      break;
    case OdometryBuffer::Coverage::kTooLate:
      return Placement::kTooLate;
    case OdometryBuffer::Coverage::kTooEarly:
      return Placement::kTooEarly;
    case OdometryBuffer::Coverage::kGap:
      return Placement::kGap;
  }
  auto newest =
      std::upper_bound(nodes_.begin(), nodes_.end(), scan.stamp,
                       [](SensorTime stamp, const KnownNode& node) { return stamp < node.stamp; });
  while (newest != nodes_.begin() && !std::prev(newest)->T_O_N) --newest;
  Pose T_R_O = Pose::Identity();
  scan.node = kNoNode;
  if (newest == nodes_.begin()) {
    // All nodes with odometry are younger: the first of them is as good a reference.
    newest = std::find_if(nodes_.begin(), nodes_.end(), is_known);
  } else {
    --newest;
  }
  if (newest != nodes_.end()) {
    scan.node = newest->id;
    T_R_O = newest->T_O_N->inverse();
  }
  scan.T_O_L = scan.poses.back().T_R_L * T_B_L_;
  for (PoseSample& sample : scan.poses) sample.T_R_L = T_R_O * sample.T_R_L * T_B_L_;
  return Placement::kPlaced;
}

std::int64_t num_returns(const Scan& scan) {
  if (scan.kind == Scan::Kind::kCloud) return static_cast<std::int64_t>(scan.points_L.size());
  return static_cast<std::int64_t>(scan.ranges_mm.size()) -
         std::count(scan.ranges_mm.begin(), scan.ranges_mm.end(), 0U);
}

}  // namespace cloister
