#include "firmware_interface/files/tum_file.hpp"

#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/files/test_files.hpp"

namespace cloister {
namespace {

TEST_CASE("a trajectory keeps stamps to the nanosecond and poses as written") {
  const auto poses = read_tum(
      "# t x y z qx qy qz qw\r\n1630577758.123456789 1 2 3 0 0 0 1\r\n"
      "1630577758.123456790 -1 0 0.5 0 0 0.70710678 0.70710678 # turned left\n",
      "o.tum");
  REQUIRE(poses);
  REQUIRE(poses->size() == 2);
  CHECK(poses->at(0).stamp.ns == 1630577758123456789);
  CHECK(poses->at(1).stamp.ns == 1630577758123456790);
  CHECK(poses->at(0).T_O_B.translation() == Eigen::Vector3d(1, 2, 3));
  CHECK(
      (poses->at(1).T_O_B * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(-1, 1, 0.5), 1e-7));
}

TEST_CASE("a trajectory without lines is empty") {
  CHECK(read_tum("", "o.tum")->empty());
  CHECK(read_tum("# nothing\n", "o.tum")->empty());
}

TEST_CASE("of trajectory lines with one stamp the last counts") {
  const auto poses =
      read_tum("1 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n1 3 0 0 0 0 0 1\n2 4 0 0 0 0 0 1\n", "o.tum");
  REQUIRE(poses);
  REQUIRE(poses->size() == 2);
  CHECK(poses->at(0).T_O_B.translation().x() == 3);
}

TEST_CASE("a malformed trajectory is refused at its first bad line") {
  struct Row {
    const char* text;
    const char* message;
  };
  const std::string good = "1 0 0 0 0 0 0 1\n";
  for (const Row& row : {Row{"2 0 0 0 0 0 0", "the line ends after 7 fields"},
                         Row{"2 0 0 0 0 0 0 1 5", "before field 9, '5'"},
                         Row{"2 0 zero 0 0 0 0 1", "field 3, 'zero', is not a finite number"},
                         Row{"2 0 nan 0 0 0 0 1", "field 3, 'nan', is not a finite number"},
                         Row{"two 0 0 0 0 0 0 1", "field 1, 'two', is not a stamp"},
                         Row{"2 0 0 0 0 0 0 0", "quaternion has length 0.0"},
                         Row{"2 0 0 0 0 0 0 2", "quaternion has length 2.0"},
                         Row{"2 0 0 0 1e200 0 0 1", "quaternion has length"},
                         Row{"2 1e9 0 0 0 0 0 1", "more than 1e8 m"},
                         Row{"0.999999999 0 0 0 0 0 0 1", "earlier than the one before"}}) {
    CAPTURE(row.text);
    const auto poses = read_tum(good + row.text + "\nanother bad line\n", "odometry.tum");
    REQUIRE_FALSE(poses);
    CHECK(poses.error().kind == ErrorKind::kInput);
    CHECK(poses.error().message.starts_with("odometry.tum:2: "));
    CHECK(test::contains(poses.error().message, row.message));
  }
  CHECK_FALSE(load_tum("no/such/file.tum"));
}

TEST_CASE("line k of nodes.tum stamps the k-th node by ascending id") {
  PoseGraph graph;
  for (const NodeId id : {3, 8, 20}) graph.nodes.emplace_back().id = id;
  graph.nodes[1].stamp = {42};
  graph.nodes[1].has_stamp = true;
  const auto lines =
      read_tum("5 0 0 0 0 0 0 1\n4 0 0 0 0 0 0 1\n4 0 0 0 0 0 0 1\n9 0 0 0 0 0 0 1\n", "nodes.tum",
               TumOrder::kAsWritten);
  REQUIRE(lines);
  REQUIRE(lines->size() == 4);
  REQUIRE(set_node_stamps(graph, *lines, "nodes.tum"));
  CHECK(graph.nodes[0].stamp.ns == 5'000'000'000);
  CHECK(graph.nodes[1].stamp.ns == 42);
  CHECK(graph.nodes[2].stamp.ns == 4'000'000'000);
  CHECK(graph.nodes[2].has_stamp);

  const auto too_few = set_node_stamps(graph, std::span(*lines).first(2), "nodes.tum");
  REQUIRE_FALSE(too_few);
  CHECK(too_few.error().message.starts_with("nodes.tum:2: "));
}

TEST_CASE("the odometry of a real sensor is read as it stands") {
  const auto poses = load_tum(CLOISTER_TEST_DATA "/missions/os1-128-3scans/odometry.tum");
  REQUIRE(poses);
  CHECK(poses->size() == 34);
  CHECK(poses->front().stamp.ns == 991587364520);
}

}  // namespace
}  // namespace cloister
