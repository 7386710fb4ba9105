#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

// OctoMap would otherwise tell about its progress on stderr.
#define OCTOMAP_NODEBUGOUT
#include <octomap/OcTree.h>

#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/map_query.hpp"
#include "firmware_interface/output/submap_colour.hpp"
#include "firmware_interface/ros2/cdr_for_tests.hpp"
#include "firmware_interface/ros2/driver_messages.hpp"
#include "firmware_interface/ros2/map_messages.hpp"

namespace cloister::ros2 {
namespace {

const MessageHeader kHeader{SensorTime{1'700'000'000'123'456'789}, "map"};

void check_header(cdr::Reader& reader, const std::string& frame_id, bool has_stamp = true) {
  CHECK(reader.get<std::int32_t>() == (has_stamp ? 1'700'000'000 : 0));
  CHECK(reader.get<std::uint32_t>() == (has_stamp ? 123'456'789 : 0));
  CHECK(reader.text() == frame_id);
}

/// A marker as an independent reader sees it.
struct ReadMarker {
  std::string name;
  std::int32_t id = 0, type = 0, action = 0;
  Pose pose = Pose::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();
  float colour[4] = {};
  std::vector<Eigen::Vector3d> points;
  std::string text;
};

ReadMarker read_marker(cdr::Reader& reader) {
  ReadMarker marker;
  check_header(reader, "map");
  marker.name = reader.text();
  marker.id = reader.get<std::int32_t>();
  marker.type = reader.get<std::int32_t>();
  marker.action = reader.get<std::int32_t>();
  marker.pose = reader.pose();
  marker.scale = reader.vector();
  for (float& channel : marker.colour) channel = reader.get<float>();
  CHECK(reader.get<std::int32_t>() == 0);  // lifetime: for ever
  CHECK(reader.get<std::uint32_t>() == 0);
  CHECK(reader.get<std::uint8_t>() == 0);  // not locked to the frame
  for (std::uint32_t i = reader.count(); i > 0; --i) marker.points.push_back(reader.vector());
  CHECK(reader.count() == 0);       // colours
  CHECK(reader.text() == "");       // texture_resource
  check_header(reader, "", false);  // texture
  CHECK(reader.text() == "");
  CHECK(reader.count() == 0);
  CHECK(reader.count() == 0);  // uv_coordinates
  marker.text = reader.text();
  CHECK(reader.text() == "");  // mesh_resource
  CHECK(reader.text() == "");  // mesh_file
  CHECK(reader.count() == 0);
  CHECK(reader.get<std::uint8_t>() == 0);
  return marker;
}

TEST_CASE("markers show boxes, ids, roots and loop closures, and take away what was there before") {
  std::vector<SubmapMarker> submaps(3);
  submaps[0].id = 4;
  submaps[0].T_M_S = pose_of(10, 0, 1, 0.5);
  submaps[0].bounds_S = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -2, 0), Eigen::Vector3d(3, 2, 2));
  submaps[0].root_M = {9, 8, 7};
  submaps[1].id = 5;  // nothing known yet: not drawn
  submaps[2].id = 6;
  submaps[2].bounds_S = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1));
  submaps[2].is_active = true;
  const std::vector<LoopMarker> loops = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {0, 1, 2}}};

  cdr::Reader reader(markers_message(kHeader, submaps, loops).encode());
  REQUIRE(reader.count() == 8);
  CHECK(read_marker(reader).action == 3);
  const ReadMarker box = read_marker(reader);
  CHECK(box.name == "submaps");
  CHECK(box.id == 4);
  CHECK(box.type == 1);
  CHECK(box.action == 0);
  CHECK(box.pose.translation().isApprox(submaps[0].T_M_S * Eigen::Vector3d(1, 0, 1), 1e-12));
  CHECK(box.pose.linear().isApprox(submaps[0].T_M_S.linear(), 1e-12));
  CHECK(box.scale == Eigen::Vector3d(4, 4, 2));
  CHECK(box.colour[0] == doctest::Approx(submap_colour(4).r / 255.0));
  const ReadMarker id = read_marker(reader);
  CHECK(id.text == "4");
  CHECK(id.pose.translation().z() == doctest::Approx(3));
  const ReadMarker root = read_marker(reader);
  CHECK(root.name == "roots");
  CHECK(root.pose.translation() == Eigen::Vector3d(9, 8, 7));
  const ReadMarker active = read_marker(reader);
  CHECK(active.id == 6);
  CHECK(active.colour[3] > box.colour[3]);
  read_marker(reader);
  read_marker(reader);
  const ReadMarker lines = read_marker(reader);
  CHECK(lines.type == 5);
  REQUIRE(lines.points.size() == 4);
  CHECK(lines.points[2] == Eigen::Vector3d(7, 8, 9));
  CHECK(reader.is_at_end());

  cdr::Reader empty(markers_message(kHeader, {}, {}).encode());
  CHECK(empty.count() == 1);
  CHECK(read_marker(empty).action == 3);
  CHECK(empty.is_at_end());
}

TEST_CASE("the occupied cloud holds the centre of every occupied voxel in its submap's colour") {
  MapBuilder map;
  Submap& first = map.add_submap(0, pose_of(1, 2, 3, 0));
  Submap& second = map.add_submap(7, pose_of(0, 0, 0, 1.5));
  map.set_voxel(first, {0, 0, 0}, 10);
  map.set_voxel(first, {-3, 9, 1}, 20);
  map.set_voxel(first, {1, 0, 0}, -10);
  map.set_voxel(second, {5, 5, 5}, 1);
  cdr::Reader reader(occupied_cloud_message(kHeader, map.view()).encode());
  check_header(reader, "map");
  CHECK(reader.count() == 1);
  REQUIRE(reader.count() == 3);
  std::map<std::string, std::pair<std::uint32_t, int>> fields;
  REQUIRE(reader.count() == 5);
  for (int i = 0; i < 5; ++i) {
    const std::string name = reader.text();
    const auto offset = reader.get<std::uint32_t>();
    fields[name] = {offset, reader.get<std::uint8_t>()};
    CHECK(reader.count() == 1);
  }
  CHECK(fields["x"] == std::pair<std::uint32_t, int>{0, 7});
  CHECK(fields["z"] == std::pair<std::uint32_t, int>{8, 7});
  CHECK(fields["rgb"] == std::pair<std::uint32_t, int>{12, 7});
  CHECK(fields["submap"] == std::pair<std::uint32_t, int>{16, 5});
  CHECK(reader.get<std::uint8_t>() == 0);
  CHECK(reader.count() == 20);
  CHECK(reader.count() == 60);
  REQUIRE(reader.count() == 60);
  std::set<std::int32_t> ids;
  float least_x = 100;
  for (int i = 0; i < 3; ++i) {
    // Three words of four bytes: the data happen to be aligned.
    const float x = reader.get<float>();
    reader.get<float>();
    reader.get<float>();
    const auto rgb = reader.get<std::uint32_t>();
    const auto id = reader.get<std::int32_t>();
    ids.insert(id);
    CHECK((rgb >> 16 & 255) == submap_colour(id).r);
    CHECK((rgb & 255) == submap_colour(id).b);
    if (id == 0) least_x = std::min(least_x, x);
  }
  CHECK(ids == std::set<std::int32_t>{0, 7});
  CHECK(least_x == doctest::Approx(1 - 0.25));
  CHECK(reader.get<std::uint8_t>() == 1);
  CHECK(reader.is_at_end());
}

TEST_CASE("the transform message says where a frame is") {
  const Pose T_M_O = pose_of(1, -2, 3, 0.4, 0.2);
  cdr::Reader reader(transform_message(kHeader, "odom", T_M_O).encode());
  CHECK(reader.count() == 1);
  check_header(reader, "map");
  CHECK(reader.text() == "odom");
  CHECK(reader.pose().isApprox(T_M_O, 1e-12));
  CHECK(reader.is_at_end());
}

TEST_CASE("an Octomap message holds the tree that OctoMap reads back") {
  MapBuilder map;
  map.fill_randomly(map.add_submap(0), 3);
  map.fill_randomly(map.add_submap(1, pose_of(0.4, 0, 0, 0.3)), 4);
  for (const bool with_log_odds : {false, true}) {
    const auto message = octomap_message(kHeader, map.view(), with_log_odds);
    REQUIRE(message);
    cdr::Reader reader(message->encode());
    check_header(reader, "map");
    CHECK(reader.get<std::uint8_t>() == (with_log_odds ? 0 : 1));
    CHECK(reader.text() == "OcTree");
    const double resolution = reader.get<double>();
    CHECK(resolution == map.info.voxel_size_m);
    std::string data;
    for (std::uint32_t i = reader.count(); i > 0; --i) data += reader.get<char>();
    CHECK(reader.is_at_end());
    octomap::OcTree tree(resolution);
    std::istringstream stream(data);
    if (with_log_odds) {
      tree.readData(stream);
    } else {
      tree.readBinaryData(stream);
    }
    const MapQuery query(map.view());
    int num_known = 0, num_wrong = 0;
    for (int x = -60; x < 60; x += 3) {
      for (int y = -60; y < 60; y += 3) {
        for (int z = -15; z < 15; z += 2) {
          const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * resolution;
          const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
          const auto state = query.at(p).state;
          const auto found = node == nullptr          ? VoxelState::kUnknown
                             : node->getLogOdds() > 0 ? VoxelState::kOccupied
                                                      : VoxelState::kFree;
          num_known += node != nullptr;
          num_wrong += found != state;
        }
      }
    }
    CHECK(num_known > 500);
    CHECK(num_wrong == 0);
  }

  MapBuilder far;
  far.set_voxel(far.add_submap(0, pose_of(5000, 0, 0, 0)), {0, 0, 0}, 5);
  CHECK_FALSE(octomap_message(kHeader, far.view(), false));
}

TEST_CASE("diagnostics carry level, names and values as they are") {
  const std::vector<Diagnostic> statuses = {
      {Diagnostic::Level::kOk,
       "cloister: scans",
       "10.0 Hz",
       "os1-64",
       {{"rate_hz", "10.0"}, {"drops", "0"}}},
      {Diagnostic::Level::kError, "cloister: odometry", "silent", "", {}}};
  cdr::Reader reader(diagnostics_message(kHeader.stamp, statuses).encode());
  check_header(reader, "");
  CHECK(reader.count() == 2);
  CHECK(reader.get<std::uint8_t>() == 0);
  CHECK(reader.text() == "cloister: scans");
  CHECK(reader.text() == "10.0 Hz");
  CHECK(reader.text() == "os1-64");
  REQUIRE(reader.count() == 2);
  CHECK(reader.text() == "rate_hz");
  CHECK(reader.text() == "10.0");
  CHECK(reader.text() == "drops");
  CHECK(reader.text() == "0");
  CHECK(reader.get<std::uint8_t>() == 2);
  CHECK(reader.text() == "cloister: odometry");
  CHECK(reader.text() == "silent");
  CHECK(reader.text() == "");
  CHECK(reader.count() == 0);
  CHECK(reader.is_at_end());
}

TEST_CASE("odometry and paths are written as they are read") {
  const Pose T = pose_of(1, 2, 3, 0.7, 0.1);
  cdr::Reader odometry(odometry_message({kHeader.stamp, T}, "odom", "body").encode());
  check_header(odometry, "odom");
  CHECK(odometry.text() == "body");
  CHECK(odometry.pose().isApprox(T, 1e-12));
  for (int i = 0; i < 36 + 6 + 36; ++i) CHECK(odometry.get<double>() == 0);
  CHECK(odometry.is_at_end());

  PoseGraph graph;
  graph.stamp = kHeader.stamp;
  graph.nodes = {{3, SensorTime{2'000'000'000}, true, T},
                 {4, SensorTime{1'000'000'000}, true, T.inverse()}};
  cdr::Reader path(path_message(graph, "map").encode());
  check_header(path, "map");
  REQUIRE(path.count() == 2);
  CHECK(path.get<std::int32_t>() == 1);
  CHECK(path.get<std::uint32_t>() == 0);
  CHECK(path.text() == "map");
  CHECK(path.pose().isApprox(T.inverse(), 1e-12));
  CHECK(path.get<std::int32_t>() == 2);
  path.get<std::uint32_t>();
  path.text();
  CHECK(path.pose().isApprox(T, 1e-12));
  CHECK(path.is_at_end());
}

}  // namespace
}  // namespace cloister::ros2
