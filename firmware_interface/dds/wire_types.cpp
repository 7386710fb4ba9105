#include "firmware_interface/dds/wire_types.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace cloister {
namespace {

static_assert(kMaxTopicPixels == cloister_wire_MAX_PIXELS);
static_assert(kMaxTopicColumns == cloister_wire_MAX_COLUMNS);

// The revision of a graph with a million nodes and as many edges.
constexpr std::uint32_t kMaxParts = 1 << 15;

GraphNode node_from_wire(const cloister_wire_Node& message) {
  return {message.id, SensorTime{message.stamp_ns}, true, from_wire(message.pose_T_M_N)};
}

GraphEdge edge_from_wire(const cloister_wire_Edge& message) {
  GraphEdge edge{message.from_id, message.to_id, from_wire(message.pose_T_from_to),
                 Matrix6d::Identity(), message.has_information};
  const double* entry = message.information;
  for (int row = 0; row < 6 && message.has_information; ++row) {
    for (int column = row; column < 6; ++column) {
      edge.information(row, column) = edge.information(column, row) = *entry++;
    }
  }
  return edge;
}

cloister_wire_Edge edge_to_wire(const GraphEdge& edge) {
  cloister_wire_Edge message{};
  message.from_id = edge.from;
  message.to_id = edge.to;
  to_wire(edge.T_from_to, message.pose_T_from_to);
  message.has_information = edge.has_information;
  double* entry = message.information;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) *entry++ = edge.information(row, column);
  }
  return message;
}

}  // namespace

void to_wire(const Pose& T_A_B, double (&pose)[7]) {
  const Eigen::Quaterniond q(T_A_B.linear());
  const double values[7] = {T_A_B.translation().x(),
                            T_A_B.translation().y(),
                            T_A_B.translation().z(),
                            q.x(),
                            q.y(),
                            q.z(),
                            q.w()};
  std::copy(std::begin(values), std::end(values), pose);
}

Pose from_wire(const double (&pose)[7]) {
  const Eigen::Quaterniond q(pose[6], pose[3], pose[4], pose[5]);
  Pose T_A_B = make_pose({pose[0], pose[1], pose[2]}, q);
  // Normalising nothing gives nothing.
  if (!(std::abs(q.norm() - 1.0) < 0.01))
    T_A_B.translation().setConstant(std::numeric_limits<double>::quiet_NaN());
  return T_A_B;
}

std::vector<cloister_wire_GraphPart> to_wire(const GraphUpdate& update) {
  const auto parts_for = [](std::size_t count, std::size_t a_part) {
    return (count + a_part - 1) / a_part;
  };
  const auto& [nodes, edges] = std::tie(update.graph.nodes, update.graph.edges);
  const std::size_t num_parts =
      std::max({std::size_t{1}, parts_for(nodes.size(), cloister_wire_NODES_A_PART),
                parts_for(edges.size(), cloister_wire_EDGES_A_PART)});
  std::vector<cloister_wire_GraphPart> parts(num_parts);
  for (std::size_t i = 0; i < num_parts; ++i) {
    cloister_wire_GraphPart& part = parts[i];
    part.session = update.session;
    part.revision = update.revision;
    part.base_revision = update.base_revision;
    part.stamp_ns = update.graph.stamp.ns;
    part.part = static_cast<std::uint32_t>(i);
    part.num_parts = static_cast<std::uint32_t>(num_parts);
    for (std::size_t n = i * cloister_wire_NODES_A_PART;
         n < nodes.size() && part.num_nodes < cloister_wire_NODES_A_PART; ++n) {
      cloister_wire_Node& node = part.nodes[part.num_nodes++];
      node.id = nodes[n].id;
      node.stamp_ns = nodes[n].stamp.ns;
      to_wire(nodes[n].T_M_N, node.pose_T_M_N);
    }
    for (std::size_t e = i * cloister_wire_EDGES_A_PART;
         e < edges.size() && part.num_edges < cloister_wire_EDGES_A_PART; ++e) {
      part.edges[part.num_edges++] = edge_to_wire(edges[e]);
    }
  }
  return parts;
}

std::optional<GraphUpdate> GraphParts::add(const cloister_wire_GraphPart& part) {
  if (part.num_parts == 0 || part.num_parts > kMaxParts || part.part >= part.num_parts ||
      part.num_nodes > cloister_wire_NODES_A_PART || part.num_edges > cloister_wire_EDGES_A_PART) {
    counters_.add(TopicCause::kGraphPartMalformed);
    return std::nullopt;
  }
  const bool continues = num_missing_ > 0 && part.session == update_.session &&
                         part.revision == update_.revision &&
                         part.base_revision == update_.base_revision &&
                         part.num_parts == has_part_.size() && !has_part_[part.part];
  if (!continues) {
    if (num_missing_ > 0) counters_.add(TopicCause::kGraphIncomplete);
    update_ = {
        part.session, part.revision, part.base_revision, {SensorTime{part.stamp_ns}, {}, {}}};
    has_part_.assign(part.num_parts, false);
    num_missing_ = part.num_parts;
  }
  has_part_[part.part] = true;
  --num_missing_;
  for (std::uint32_t i = 0; i < part.num_nodes; ++i)
    update_.graph.nodes.push_back(node_from_wire(part.nodes[i]));
  for (std::uint32_t i = 0; i < part.num_edges; ++i)
    update_.graph.edges.push_back(edge_from_wire(part.edges[i]));
  if (num_missing_ > 0) return std::nullopt;
  return std::exchange(update_, {});
}

bool from_wire(const cloister_wire_OrganisedScan& message, int num_beams, int num_columns,
               Scan& scan) {
  const auto beams = static_cast<std::size_t>(num_beams);
  const auto columns = static_cast<std::size_t>(num_columns);
  if (message.num_beams != beams || message.num_columns != columns ||
      beams * columns > kMaxTopicPixels || columns > kMaxTopicColumns) {
    return false;
  }
  scan.kind = Scan::Kind::kOrganised;
  scan.stamp = {message.stamp_ns};
  scan.last_packet = {message.last_packet_ns};
  scan.ranges_mm.assign(message.ranges_mm, message.ranges_mm + beams * columns);
  scan.column_valid.assign(message.column_valid, message.column_valid + columns);
  scan.column_stamps.resize(columns);
  for (std::size_t i = 0; i < columns; ++i) scan.column_stamps[i] = {message.column_stamps_ns[i]};
  return true;
}

void to_wire(const Scan& scan, int num_beams, int num_columns, std::uint32_t scan_number,
             cloister_wire_OrganisedScan& message) {
  // Memory from a pool holds what was there before: all of it is written.
  message.stamp_ns = scan.stamp.ns;
  message.last_packet_ns = scan.last_packet.ns;
  message.scan_number = scan_number;
  message.num_beams = static_cast<std::uint16_t>(num_beams);
  message.num_columns = static_cast<std::uint16_t>(num_columns);
  const auto copy = [](const auto& from, auto& to) {
    const auto end = std::copy(from.begin(), from.end(), std::begin(to));
    std::fill(end, std::end(to), 0);
  };
  copy(scan.ranges_mm, message.ranges_mm);
  std::fill(std::begin(message.reflectivity), std::end(message.reflectivity), std::uint8_t{0});
  copy(scan.column_valid, message.column_valid);
  std::fill(std::begin(message.column_stamps_ns), std::end(message.column_stamps_ns), 0);
  for (std::size_t i = 0; i < scan.column_stamps.size(); ++i)
    message.column_stamps_ns[i] = scan.column_stamps[i].ns;
}

}  // namespace cloister
