#include <cloister_native.h>

#include <algorithm>
#include <limits>
#include <string>

#include <dds/dds.h>
#include <doctest/doctest.h>

#include "firmware_interface/dds/dds_options.hpp"
#include "firmware_interface/dds/wire_types.hpp"

namespace cloister {
namespace {

TEST_CASE(
    "what comes in has a fixed size, so that it may lie in shared memory, and no other size than "
    "it had") {
  for (const dds_topic_descriptor_t* descriptor :
       {&cloister_wire_OrganisedScan_desc, &cloister_wire_Odometry_desc,
        &cloister_wire_GraphPart_desc}) {
    CAPTURE(std::string(descriptor->m_typename));
    CHECK((descriptor->m_flagset & DDS_TOPIC_FIXED_SIZE) != 0);
  }
  CHECK(std::string(cloister_wire_OrganisedScan_desc.m_typename) ==
        "cloister::wire::OrganisedScan");
  CHECK(sizeof(cloister_wire_OrganisedScan) == 24 + 65536 * 4 + 65536 + 2048 * 8 + 2048);
  CHECK(sizeof(cloister_wire_Odometry) == 72);
  CHECK(sizeof(cloister_wire_Node) == 72);
  CHECK(sizeof(cloister_wire_Edge) == 248);
  CHECK(sizeof(cloister_wire_GraphPart) == 48 + 64 * 72 + 64 * 248);
}

TEST_CASE("a scan goes over the wire and back, and one of another sensor is refused") {
  Scan scan;
  scan.stamp = {5};
  scan.last_packet = {7};
  for (std::uint32_t i = 0; i < 32 * 2048; ++i) scan.ranges_mm.push_back(i);
  for (std::int64_t i = 0; i < 2048; ++i) scan.column_stamps.push_back({i * 100});
  scan.column_valid.assign(2048, 1);
  scan.column_valid[3] = 0;
  const auto message = std::make_unique<cloister_wire_OrganisedScan>();
  to_wire(scan, 32, 2048, 9, *message);
  CHECK(message->scan_number == 9);
  Scan back;
  REQUIRE(from_wire(*message, 32, 2048, back));
  CHECK(back.stamp == scan.stamp);
  CHECK(back.last_packet == scan.last_packet);
  CHECK(back.ranges_mm == scan.ranges_mm);
  CHECK(back.column_stamps == scan.column_stamps);
  CHECK(back.column_valid == scan.column_valid);
  CHECK_FALSE(from_wire(*message, 64, 1024, back));
  message->num_beams = 65535;
  CHECK_FALSE(from_wire(*message, 65535, 2048, back));
}

GraphUpdate large_graph(int num_nodes) {
  GraphUpdate update{1, 2, 0, {SensorTime{50}, {}, {}}};
  for (int i = 0; i < num_nodes; ++i) {
    update.graph.nodes.push_back(
        {i, SensorTime{i}, true, make_pose({i * 1.0, 0, 0}, Eigen::Quaterniond(1, 2, 3, i))});
    if (i == 0) continue;
    GraphEdge edge{i - 1, i, Pose::Identity(), Matrix6d::Identity(), i % 2 == 0};
    edge.information(0, 5) = edge.information(5, 0) = 0.25 * i;
    update.graph.edges.push_back(edge);
  }
  return update;
}

TEST_CASE("a graph of any size arrives whole, its parts in any order and some of them twice") {
  const GraphUpdate sent = large_graph(200);
  auto parts = to_wire(sent);
  REQUIRE(parts.size() == 4);
  std::reverse(parts.begin(), parts.end());
  Counters<TopicCause> counters;
  GraphParts assembler(counters);
  for (std::size_t i = 0; i < 3; ++i) CHECK_FALSE(assembler.add(parts[i]).has_value());
  const auto received = assembler.add(parts[3]);
  REQUIRE(received.has_value());
  CHECK(received->session == 1);
  CHECK(received->revision == 2);
  CHECK(received->graph.nodes.size() == 200);
  CHECK(received->graph.edges.size() == 199);
  for (const GraphNode& node : received->graph.nodes) {
    const auto id = static_cast<std::size_t>(node.id);
    CHECK(node.T_M_N.isApprox(sent.graph.nodes[id].T_M_N, 1e-12));
  }
  for (const GraphEdge& edge : received->graph.edges) {
    CHECK(edge.has_information == (edge.to % 2 == 0));
    if (edge.has_information) CHECK(edge.information(5, 0) == 0.25 * static_cast<double>(edge.to));
  }
  CHECK(counters[TopicCause::kGraphIncomplete] == 0);
}

TEST_CASE(
    "parts that contradict themselves are dropped, and a revision with a part missing is counted") {
  Counters<TopicCause> counters;
  GraphParts assembler(counters);
  auto parts = to_wire(large_graph(200));
  cloister_wire_GraphPart bad = parts[0];
  SUBCASE("more nodes than fit") { bad.num_nodes = 65; }
  SUBCASE("a part beyond the last") { bad.part = 4; }
  SUBCASE("no parts") { bad.num_parts = 0; }
  SUBCASE("parts without end") { bad.num_parts = 0xffffffff; }
  CHECK_FALSE(assembler.add(bad).has_value());
  CHECK(counters[TopicCause::kGraphPartMalformed] == 1);
  CHECK_FALSE(assembler.add(parts[0]).has_value());
  for (auto& part : parts) part.revision = 3;
  for (std::size_t i = 0; i < 3; ++i) CHECK_FALSE(assembler.add(parts[i]).has_value());
  CHECK(counters[TopicCause::kGraphIncomplete] == 1);
  CHECK(assembler.add(parts[3]).has_value());
}

TEST_CASE("a pose without a rotation is no pose") {
  const double zero[7] = {1, 2, 3, 0, 0, 0, 0};
  CHECK_FALSE(is_finite(from_wire(zero)));
  const double nan[7] = {1, 2, 3, 0, 0, 0, std::numeric_limits<double>::quiet_NaN()};
  CHECK_FALSE(is_finite(from_wire(nan)));
}

TEST_CASE(
    "the configuration names interface, peers, ports and shared memory, and nothing can break out "
    "of it") {
  DdsOptions options;
  options.interface = "eth0\"/><x";
  options.peers = "10.0.0.1,10.0.0.2";
  options.first_port = 21000;
  options.external_address = "192.0.2.1";
  const std::string xml = cyclone_xml(options, std::nullopt);
  CHECK(xml.find("name=\"eth0&quot;/&gt;&lt;x\"") != std::string::npos);
  CHECK(xml.find("<Peer Address=\"10.0.0.1\"/><Peer Address=\"10.0.0.2\"/>") != std::string::npos);
  CHECK(xml.find("<Base>21000</Base>") != std::string::npos);
  CHECK(xml.find("<ExternalNetworkAddress>192.0.2.1</ExternalNetworkAddress>") !=
        std::string::npos);
  CHECK(cyclone_xml({}, std::nullopt).find("<ExternalNetworkAddress>auto<") != std::string::npos);
  CHECK(xml.find("<SharedMemory><Enable>false</Enable></SharedMemory>") != std::string::npos);
  CHECK(cyclone_xml(options, "[01:02]").find("<Enable>true</Enable><Locator>[01:02]</Locator>") !=
        std::string::npos);
  CHECK(cyclone_xml({}, std::nullopt).find("<Peer Address=\"127.0.0.1\"/>") != std::string::npos);
}

}  // namespace
}  // namespace cloister
