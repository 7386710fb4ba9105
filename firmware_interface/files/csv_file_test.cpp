#include "firmware_interface/files/csv_file.hpp"

#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/files/test_files.hpp"

namespace cloister {
namespace {

TEST_CASE("points are read with and without a header") {
  for (const char* text : {"1,2,3\n-4.5,5e1,6", "x,y,z\n1,2,3\n-4.5,5e1,6\n",
                           "# points\r\nX, Y ,Z\r\n1, 2,3\r\n\r\n-4.5 , 5e1,6\r\n"}) {
    CAPTURE(text);
    const auto points = read_points_csv(text, "p.csv");
    REQUIRE(points);
    REQUIRE(points->size() == 2);
    CHECK(points->at(0) == Eigen::Vector3d(1, 2, 3));
    CHECK(points->at(1) == Eigen::Vector3d(-4.5, 50, 6));
  }
  CHECK(read_points_csv("", "p.csv")->empty());
  CHECK(read_points_csv("x,y,z\n", "p.csv")->empty());
}

TEST_CASE("pairs are read with and without a header") {
  const auto pairs = read_pairs_csv("i,j\n0,57\n57,0\n", "pairs.csv");
  REQUIRE(pairs);
  CHECK(*pairs == std::vector<NodePair>{{0, 57}, {57, 0}});
  CHECK(read_pairs_csv("3,4", "pairs.csv")->size() == 1);
}

TEST_CASE("malformed rows are refused with their line") {
  struct Row {
    const char* text;
    const char* message;
  };
  for (const Row& row :
       {Row{"1,2", "the line ends after 2 fields"}, Row{"1,2,3,4", "before field 4"},
        Row{"1,2,", "field 3, ''"}, Row{"1,2,3,", "before field 4, ''"}, Row{"1,,3", "field 2, ''"},
        Row{"1 2 3", "field 1, '1 2 3'"}, Row{"1;2;3", "field 1, '1;2;3'"}, Row{"1,nan,3", "'nan'"},
        Row{"x,y,z", "field 1, 'x'"}}) {
    CAPTURE(row.text);
    const auto points = read_points_csv(std::string("x,y,z\n") + row.text + "\n", "p.csv");
    REQUIRE_FALSE(points);
    CHECK(points.error().kind == ErrorKind::kInput);
    CHECK(points.error().message.starts_with("p.csv:2: "));
    CHECK(test::contains(points.error().message, row.message));
  }
  CHECK(read_points_csv("y,x,z\n", "p.csv").error().message.starts_with("p.csv:1: field 1, 'y'"));
  CHECK(read_points_csv("x,y\n1,2", "p.csv").error().message.starts_with("p.csv:1: "));
  CHECK(read_pairs_csv("1,2.5\n", "pairs.csv")
            .error()
            .message.starts_with("pairs.csv:1: field 2, '2.5'"));
  CHECK(read_pairs_csv("1,2,3\n", "pairs.csv").error().message.starts_with("pairs.csv:1: "));
  CHECK_FALSE(load_points_csv("no/such.csv"));
  CHECK_FALSE(load_pairs_csv("no/such.csv"));
}

}  // namespace
}  // namespace cloister
