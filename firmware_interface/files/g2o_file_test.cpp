#include "firmware_interface/files/g2o_file.hpp"

#include <random>
#include <string>

#include <Eigen/Geometry>
#include <doctest/doctest.h>

#include "firmware_interface/files/test_files.hpp"
#include "firmware_interface/files/text_format.hpp"

namespace cloister {
namespace {

const std::string kUnitInformation = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
const std::string kTwoNodes =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
const std::string kPose = " 1 0 0 0 0 0 1";

TEST_CASE("a graph is read whatever the order of its lines, ids and ends") {
  G2oStats stats;
  const auto graph =
      read_g2o("\xEF\xBB\xBF# made by hand\r\nPLATFORM_ID 0\r\nEDGE_SE3:QUAT 7000000000 3" + kPose +
                   kUnitInformation + "\r\nEDGE_SE3:QUAT 3 7000000000" + kPose + kUnitInformation +
                   "\nVERTEX_SE3:QUAT_TIME 7000000000 1 2 3 0 0 0 1 1690309710 85582848\n"
                   "EDGE_SE3:QUAT 7000000000 3" +
                   kPose + kUnitInformation +
                   "\nFIX 3\nVERTEX_SE3:QUAT 3 0 0 0 0 0 0.001 1\n"
                   "VERTEX_SE3:QUAT 3 0 0 0 0 0 0.001 1",
               "g.g2o", {}, &stats);
  REQUIRE(graph);
  REQUIRE(graph->nodes.size() == 2);
  CHECK(graph->nodes[0].id == 3);
  CHECK_FALSE(graph->nodes[0].has_stamp);
  CHECK(graph->nodes[0].T_M_N.linear().determinant() == doctest::Approx(1).epsilon(1e-14));
  CHECK(graph->nodes[1].id == 7000000000);
  CHECK(graph->nodes[1].has_stamp);
  CHECK(graph->nodes[1].stamp.ns == 1690309710085582848);
  CHECK(graph->nodes[1].T_M_N.translation() == Eigen::Vector3d(1, 2, 3));
  REQUIRE(graph->edges.size() == 3);
  CHECK(graph->edges[0].from == 7000000000);
  CHECK(graph->edges[1].from == 3);
  CHECK(graph->edges[2].to == 3);
  CHECK(graph->edges[0].has_information);
  CHECK(stats.comments == 1);
  CHECK(stats.skipped_records == 2);
  CHECK(stats.repeated_vertices == 1);
}

TEST_CASE("graphs of no node, one node and no edges are graphs") {
  CHECK(read_g2o("", "g.g2o", {})->nodes.empty());
  CHECK(read_g2o("# nothing", "g.g2o", {})->nodes.empty());
  CHECK(read_g2o("VERTEX_SE3:QUAT 5 0 0 0 0 0 0 1", "g.g2o", {})->nodes.size() == 1);
  CHECK(read_g2o(kTwoNodes, "g.g2o", {})->nodes.size() == 2);
}

TEST_CASE("the upper triangle of the information is laid out by rows") {
  std::string text = kTwoNodes + "EDGE_SE3:QUAT 0 1" + kPose;
  Matrix6d expected = 100.0 * Matrix6d::Identity();
  double entry = 0.25;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column, entry += 0.25) {
      expected(row, column) += entry;
      if (row != column) expected(column, row) += entry;
      text += ' ';
      append_number(text, expected(row, column));
    }
  }
  const auto graph = read_g2o(text, "g.g2o", {});
  REQUIRE(graph);
  CHECK(graph->edges[0].information == expected);
}

TEST_CASE("an edge without information is refused unless a default stands in") {
  const std::string text = kTwoNodes + "EDGE_SE3:QUAT 0 1" + kPose + "\n";
  const auto refused = read_g2o(text, "g.g2o", {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.starts_with("g.g2o:3: "));
  CHECK(test::contains(refused.error().message, "fusion.default_information"));

  G2oStats stats;
  const auto graph = read_g2o(text, "g.g2o", {.default_information = 25.0}, &stats);
  REQUIRE(graph);
  CHECK_FALSE(graph->edges[0].has_information);
  CHECK(graph->edges[0].information == 25.0 * Matrix6d::Identity());
  CHECK(stats.edges_without_information == 1);
}

TEST_CASE("semidefinite information is accepted at any scale, indefinite is not") {
  const unsigned seed = 3;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 200; ++k) {
    const int rank = k % 7;
    Matrix6d root = Matrix6d::Zero();
    for (int row = 0; row < 6; ++row) {
      const double scale = std::pow(10.0, 3.0 * normal(random));
      for (int column = 0; column < rank; ++column) root(row, column) = scale * normal(random);
    }
    const Matrix6d information = root * root.transpose();
    const Eigen::Vector<double, 6> diagonal = information.diagonal();
    std::string semidefinite = kTwoNodes + "EDGE_SE3:QUAT 0 1" + kPose;
    std::string indefinite = semidefinite;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        append_number(semidefinite += ' ', information(row, column));
        // One correlation pushed beyond 1.
        const bool is_pushed = row == 2 && column == 4;
        append_number(indefinite += ' ', is_pushed
                                             ? 1.01 * std::sqrt(diagonal[2] * diagonal[4]) + 1e-3
                                             : information(row, column));
      }
    }
    CAPTURE(k);
    CHECK(read_g2o(semidefinite, "g.g2o", {}));
    const auto refused = read_g2o(indefinite, "g.g2o", {});
    REQUIRE_FALSE(refused);
    CHECK(test::contains(refused.error().message,
                         "g.g2o:3: the information matrix is not positive semidefinite"));
  }
}

TEST_CASE("a malformed graph is refused at its first bad line") {
  struct Row {
    std::string text;
    const char* message;
  };
  const std::string edge = "EDGE_SE3:QUAT 0 1" + kPose;
  for (const Row& row :
       {Row{"VERTEX_SE3:QUAT 2 0 0 0 0 0 0", "the line ends after 8 fields"},
        Row{"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 1 9", "before field 10, '9'"},
        Row{"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 x", "field 9, 'x', is not a finite number"},
        Row{"VERTEX_SE3:QUAT 2 0 inf 0 0 0 0 1", "'inf'"},
        Row{"VERTEX_SE3:QUAT 2 0 1e999 0 0 0 0 1", "'1e999'"},
        Row{"VERTEX_SE3:QUAT 2.5 0 0 0 0 0 0 1", "'2.5', is not an integer"},
        Row{"VERTEX_SE3:QUAT -1 0 0 0 0 0 0 1", "vertex id is negative"},
        Row{"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 0", "quaternion has length 0"},
        Row{"VERTEX_SE3:QUAT 2 0 0 0 0 0 0 1.2", "quaternion has length 1.2"},
        Row{"VERTEX_SE3:QUAT 1 1 0 0.5 0 0 0 1", "vertex 1 was written before with other content"},
        Row{"VERTEX_SE3:QUAT_TIME 1 1 0 0 0 0 0 1 5 0", "vertex 1 was written before"},
        Row{"VERTEX_SE3:QUAT_TIME 2 0 0 0 0 0 0 1 5", "ends after 10 fields"},
        Row{"VERTEX_SE3:QUAT_TIME 2 0 0 0 0 0 0 1 5 1000000000", "0 <= nsec < 1e9"},
        Row{"VERTEX_SE3:QUAT_TIME 2 0 0 0 0 0 0 1 99999999999 0", "0 <= nsec < 1e9"},
        Row{"EDGE_SE3:QUAT 0 9" + kPose + kUnitInformation, "names node 9, which has no vertex"},
        Row{"EDGE_SE3:QUAT -3 0" + kPose + kUnitInformation, "names node -3"},
        Row{"EDGE_SE3:QUAT 1 1" + kPose + kUnitInformation, "joins a node to itself"},
        Row{edge + kUnitInformation + " 0", "before field 32"},
        Row{edge + " 1 0 0 0 0 0", "the line ends after 16 fields"},
        Row{edge + " nan 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1", "'nan'"},
        Row{edge + " -1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1", "not positive semidefinite"},
        Row{edge + " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 -1", "not positive semidefinite"},
        Row{edge + " 0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1", "not positive semidefinite"},
        Row{edge + " 1e308 0 0 0 0 1e308 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",
            "not positive semidefinite"},
        Row{"12 0 0", "does not begin with the name of a record"},
        Row{std::string("\0\1\2", 3), "does not begin with the name of a record"}}) {
    CAPTURE(row.text);
    const auto graph = read_g2o(kTwoNodes + row.text + "\n", "graph.g2o", {});
    REQUIRE_FALSE(graph);
    CHECK(graph.error().kind == ErrorKind::kInput);
    CHECK(graph.error().message.starts_with("graph.g2o:3: "));
    CHECK(test::contains(graph.error().message, row.message));
  }
  const auto missing = load_g2o("no/such/graph.g2o", {});
  REQUIRE_FALSE(missing);
  CHECK(missing.error().message.starts_with("no/such/graph.g2o: "));
}

TEST_CASE("the graphs of the sample missions are read") {
  G2oStats stats;
  const auto norlab =
      load_g2o(CLOISTER_TEST_DATA "/missions/norlab/slam_pose_graph.slam", {}, &stats);
  REQUIRE(norlab);
  CHECK(norlab->nodes.size() == 14);
  CHECK(norlab->edges.size() == 13);
  CHECK(norlab->nodes[8].stamp.ns == 1690309710085582848);
  CHECK(stats.skipped_records == 1);
  CHECK(stats.comments == 3);

  const auto one = load_g2o(
      CLOISTER_TEST_DATA "/missions/os1-64-capture/pose_graph/000000_278211490950.g2o", {});
  REQUIRE(one);
  CHECK(one->nodes.size() == 1);
  CHECK(one->edges.empty());
}

}  // namespace
}  // namespace cloister
