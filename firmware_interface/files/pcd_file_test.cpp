#include "firmware_interface/files/pcd_file.hpp"

#include <lzf.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/files/test_files.hpp"

namespace cloister {
namespace {

using Points = std::vector<Eigen::Vector3f>;

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   const std::string& counts, const std::string& width_height_points,
                   const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " +
         sizes + "\nTYPE " + types + "\nCOUNT " + counts + "\n" + width_height_points +
         "VIEWPOINT 1 2 3 1 0 0 0\nDATA " + data + "\n";
}

std::string xyz_header(int num_points, const std::string& data) {
  const std::string n = std::to_string(num_points);
  return header("x y z", "4 4 4", "F F F", "1 1 1", "WIDTH " + n + "\nHEIGHT 1\nPOINTS " + n + "\n",
                data);
}

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// The body of a compressed cloud.
std::string compressed(const std::string& plain) {
  std::string packed(plain.size() + 64, '\0');
  packed.resize(lzf_compress(plain.data(), static_cast<unsigned>(plain.size()), packed.data(),
                             static_cast<unsigned>(packed.size())));
  std::string body;
  append(body, static_cast<std::uint32_t>(packed.size()));
  append(body, static_cast<std::uint32_t>(plain.size()));
  return body + packed;
}

TEST_CASE("an ascii cloud is read by field names, and points that are not finite are dropped") {
  Points points = {{9, 9, 9}};
  const auto stats =
      read_pcd(header("rgb z normal x y", "4 8 4 4 2", "U F F F I", "1 1 3 1 1",
                      "WIDTH 2\nHEIGHT 2\nPOINTS 4\n", "ascii") +
                   "0 3 0 0 1 1 2\r\n0 nan 0 0 1 nan nan\n0 1e300 0 0 1 1 1\n7 -6.5 0 0 1 4e0 5\n",
               "c.pcd", points);
  REQUIRE(stats);
  CHECK(stats->points == 2);
  CHECK(stats->not_finite == 2);
  CHECK(points == Points{{9, 9, 9}, {1, 2, 3}, {4, 5, -6.5f}});
}

TEST_CASE("a binary cloud is read whatever the type of its coordinates") {
  std::string bytes = header("intensity x _ y z", "1 8 1 2 4", "U F U I I", "1 1 5 1 1",
                             "WIDTH 3\nHEIGHT 1\nPOINTS 3\n", "binary");
  const double x[] = {1.5, std::numeric_limits<double>::infinity(), -1e-3};
  for (std::int16_t k = 0; k < 3; ++k) {
    bytes += 'i';
    append(bytes, x[k]);
    bytes += "#####";
    append(bytes, static_cast<std::int16_t>(-300 * k));
    append(bytes, std::int32_t{100000} * k);
  }
  for (const std::string& surplus : {std::string(), std::string("\0\0\0", 3)}) {
    Points points;
    const auto stats = read_pcd(bytes + surplus, "c.pcd", points);
    REQUIRE(stats);
    CHECK(stats->not_finite == 1);
    CHECK(points == Points{{1.5f, 0, 0}, {-1e-3f, -600, 200000}});
  }
}

TEST_CASE("every type and size of a coordinate is read") {
  const auto read_one = [](const std::string& size, const std::string& type, const auto value) {
    std::string bytes = header("x y z", size + " 4 4", type + " F F", "1 1 1",
                               "WIDTH 1\nHEIGHT 1\nPOINTS 1\n", "binary");
    append(bytes, value);
    append(bytes, 2.0f);
    append(bytes, 3.0f);
    Points points;
    REQUIRE(read_pcd(bytes, "c.pcd", points));
    return points.at(0).x();
  };
  CHECK(read_one("1", "I", std::int8_t{-100}) == -100.0f);
  CHECK(read_one("1", "U", std::uint8_t{200}) == 200.0f);
  CHECK(read_one("2", "I", std::int16_t{-30000}) == -30000.0f);
  CHECK(read_one("2", "U", std::uint16_t{60000}) == 60000.0f);
  CHECK(read_one("4", "I", std::int32_t{-1 << 30}) == -1073741824.0f);
  CHECK(read_one("4", "U", std::uint32_t{1U << 31}) == 2147483648.0f);
  CHECK(read_one("4", "F", 0.1f) == 0.1f);
  CHECK(read_one("8", "I", std::int64_t{-5}) == -5.0f);
  CHECK(read_one("8", "U", std::uint64_t{1} << 40) == 1099511627776.0f);
  CHECK(read_one("8", "F", 0.1) == 0.1f);
}

TEST_CASE("a compressed cloud is read field by field") {
  std::string plain;
  for (int k = 0; k < 100; ++k) append(plain, static_cast<float>(k));
  for (int k = 0; k < 100; ++k) append(plain, static_cast<std::uint16_t>(7));
  for (int k = 0; k < 100; ++k) append(plain, 0.5f);
  for (int k = 0; k < 100; ++k) append(plain, static_cast<double>(-k));
  const std::string bytes = header("x ring y z", "4 2 4 8", "F U F F", "1 1 1 1",
                                   "WIDTH 10\nHEIGHT 10\nPOINTS 100\n", "binary_compressed") +
                            compressed(plain);
  Points points;
  REQUIRE(read_pcd(bytes, "c.pcd", points));
  REQUIRE(points.size() == 100);
  CHECK(points[42] == Eigen::Vector3f(42, 0.5f, -42));
}

TEST_CASE("a cloud without points, and headers without COUNT, HEIGHT or POINTS, are read") {
  Points points;
  CHECK(read_pcd(xyz_header(0, "ascii"), "c.pcd", points)->points == 0);
  CHECK(read_pcd(xyz_header(0, "binary"), "c.pcd", points)->points == 0);
  CHECK(read_pcd(xyz_header(0, "binary_compressed"), "c.pcd", points)->points == 0);
  CHECK(
      read_pcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n1 2 3", "c.pcd", points)
          ->points == 1);
  CHECK(
      read_pcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 3", "c.pcd", points)
          ->points == 1);
}

TEST_CASE("a malformed header is refused with its line") {
  struct Row {
    std::string text;
    const char* message;
  };
  const std::string good = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  for (const Row& row : {
           Row{"", ":0: the header ends without a DATA line"},
           Row{good, ":4: the header ends without a DATA line"},
           Row{"ply\nformat ascii 1.0\n", ":1: the line is none of a PCD header's"},
           Row{"FIELDS x y z\nSIZE 4 4 3\n", ":2: a SIZE is none of"},
           Row{"SIZE 4 four 4\n", ":1: field 3, 'four'"},
           Row{"TYPE F F D\n", ":1: a TYPE is none of"},
           Row{"COUNT 1 0 1\n", ":1: a COUNT is not between"},
           Row{"COUNT 1 1 99999999999\n", ":1: a COUNT is not between"},
           Row{"WIDTH -1\n", ":1: the number is out of range"},
           Row{"WIDTH 99999999999999\n", ":1: the number is out of range"},
           Row{"WIDTH 5 5\n", ":1: the line should end"},
           Row{good + "WIDTH 1\nDATA binary_lz4\n", ":6: DATA is none of"},
           Row{good + "WIDTH 1\nDATA\n", ":6: DATA is none of"},
           Row{good + "DATA ascii\n", ":5: header: neither WIDTH nor POINTS"},
           Row{good + "WIDTH 2\nPOINTS 3\nDATA ascii\n",
               ":7: header: POINTS is not WIDTH times HEIGHT"},
           Row{good + "WIDTH 1000000000000\nHEIGHT 1000000000000\nDATA binary\n",
               ":7: header: WIDTH times HEIGHT"},
           Row{"FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 0\nDATA ascii\n",
               ":5: header: FIELDS does not name x, y and z"},
           Row{"FIELDS x y z x\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 0\nDATA ascii\n",
               ":5: header: x, y and z must be"},
           Row{"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 2 1 1\nWIDTH 0\nDATA ascii\n",
               ":6: header: x, y and z must be"},
           Row{"FIELDS x y z\nSIZE 4 4 2\nTYPE F F F\nWIDTH 0\nDATA ascii\n",
               ":5: header: a coordinate of TYPE F"},
           Row{"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 0\nDATA ascii\n",
               ":5: header: FIELDS, SIZE, TYPE and COUNT"},
           Row{"FIELDS x y z big\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 1048576\nWIDTH 0\nDATA "
               "ascii\n",
               ":6: header: a point takes more"},
       }) {
    CAPTURE(row.text);
    Points points;
    const auto stats = read_pcd(row.text, "cloud.pcd", points);
    REQUIRE_FALSE(stats);
    CHECK(stats.error().kind == ErrorKind::kInput);
    CHECK(stats.error().message.starts_with(std::string("cloud.pcd") + row.message));
  }
}

TEST_CASE("a body that does not fit its header is refused with its place, and no point is kept") {
  struct Row {
    std::string bytes;
    const char* message;
  };
  const std::string compressed_header = xyz_header(2, "binary_compressed");
  const std::string body = compressed(std::string(24, 'a'));
  std::string other_size = body;
  other_size[4] = 36;
  std::string longer_than_file = body;
  longer_than_file[0] = 100;
  std::string damaged = body;
  damaged[8] = '\x7f';
  std::string bomb =
      header("x y z", "4 4 4", "F F F", "1 1 1", "WIDTH 300000000\n", "binary_compressed");
  append(bomb, std::uint32_t{4});
  append(bomb, std::uint32_t{3600000000});
  const std::string huge =
      header("x y z", "4 4 4", "F F F", "1 1 1", "WIDTH 1099511627776\n", "binary");
  const std::string huge_ascii =
      header("x y z", "4 4 4", "F F F", "1 1 1", "WIDTH 1099511627776\n", "ascii");
  for (const Row& row : {
           Row{xyz_header(2, "ascii") + "1 2 3\n",
               "c.pcd:12: the file ends after 1 of its 2 points"},
           Row{xyz_header(1, "ascii") + "1 2 3\n4 5 6\n",
               "c.pcd:13: a line follows the last point"},
           Row{xyz_header(2, "ascii") + "1 2 3\n4 5\n", "c.pcd:13: the line has 2 values"},
           Row{xyz_header(2, "ascii") + "1 2 3\n4 5 6 7\n", "c.pcd:13: the line has 4 values"},
           Row{xyz_header(2, "ascii") + "1 2 3\n4 five 6\n",
               "c.pcd:13: a coordinate is not a number"},
           Row{huge_ascii + "1 2 3\n", "c.pcd:10: the file ends after 1 of its"},
           Row{xyz_header(2, "binary") + std::string(23, 'a'),
               "c.pcd: byte 187: the file ends before its 2 points"},
           Row{huge + std::string(24, 'a'), "the file ends before its 1099511627776 points"},
           Row{compressed_header, "c.pcd: byte 175: the file ends before the sizes"},
           Row{compressed_header + body.substr(0, 7), "the file ends before the sizes"},
           Row{compressed_header + body.substr(0, body.size() - 1),
               "bytes of its compressed body do"},
           Row{compressed_header + longer_than_file, "the file ends before the 100 bytes"},
           Row{compressed_header + other_size,
               "c.pcd: byte 179: the uncompressed size does not match"},
           Row{compressed_header + damaged, "c.pcd: byte 183: the body does not decompress"},
           Row{bomb + "aaaa", "the body claims to hold more than it can"},
       }) {
    CAPTURE(row.message);
    Points points = {{1, 1, 1}};
    const auto stats = read_pcd(row.bytes, "c.pcd", points);
    REQUIRE_FALSE(stats);
    CHECK(stats.error().kind == ErrorKind::kInput);
    CAPTURE(stats.error().message);
    CHECK(stats.error().message.starts_with("c.pcd:"));
    CHECK(test::contains(stats.error().message, row.message));
    CHECK(points.size() == 1);
  }
}

TEST_CASE("the clouds of a real sensor are read, and cut off anywhere they are refused") {
  const std::string path =
      CLOISTER_TEST_DATA "/missions/norlab/individual_clouds/cloud_1690309710_85582848.pcd";
  Points points;
  const auto stats = load_pcd(path, points);
  REQUIRE(stats);
  CHECK(stats->points == 41406);
  float max_range_m = 0;
  for (const auto& point : points) max_range_m = std::max(max_range_m, point.norm());
  CHECK(max_range_m > 100.0f);
  CHECK(max_range_m < 200.0f);

  const auto bytes = read_file(path);
  REQUIRE(bytes);
  for (std::size_t size = 0; size < bytes->size(); size += 1 + size / 3) {
    CAPTURE(size);
    CHECK_FALSE(read_pcd(std::string_view(*bytes).substr(0, size), "c.pcd", points));
  }
  CHECK_FALSE(load_pcd("no/such.pcd", points));
}

}  // namespace
}  // namespace cloister
