#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "bench/experiments/doubled_surface.hpp"
#include "bench/experiments/growth_plot.hpp"
#include "bench/experiments/limits.hpp"
#include "bench/experiments/pair_doubt.hpp"
#include "bench/experiments/rounds.hpp"
#include "bench/simulate/walk.hpp"
#include "bench/simulate/world.hpp"

namespace cloister {
namespace {

constexpr const char* kTimeline =
    "stamp_ns,submap,integrate_ms,latency_ms,submaps,map_bytes,queue_depth,overlap_ratio\n"
    "100,0,4.5,8.5,1,1000,0,1\n"
    "200,0,4.5,8.5,2,3000,0,0.9\n"
    "300,1,4.5,8.5,1,2000,0,0.8\n";

TEST_CASE("a timeline is read by its columns' names") {
  const auto growth = parse_timeline(kTimeline, "timeline.csv");
  REQUIRE(growth);
  REQUIRE(growth->size() == 3);
  CHECK((*growth)[1].stamp == SensorTime{200});
  CHECK((*growth)[1].submaps == 2);
  CHECK((*growth)[1].bytes == 3000);
}

TEST_CASE("a malformed timeline is refused with its line") {
  const std::string head = "stamp_ns,submaps,map_bytes\n";
  for (const auto& [text, line] : {std::pair<std::string, int>{"", 0},
                                   {"stamp_ns,submaps\n1,2\n", 1},
                                   {head + "1,2\n", 2},
                                   {head + "1,2,3\n2,x,3\n", 3},
                                   {head + "5,1,1\n5,1,1\n", 3}}) {
    const auto growth = parse_timeline(text, "t.csv");
    REQUIRE(!growth);
    CHECK(growth.error().message.starts_with("t.csv:" + std::to_string(line) + ":"));
  }
}

TEST_CASE("the map's bytes at a stamp are those after the last scan before it") {
  const auto growth = parse_timeline(kTimeline, "timeline.csv");
  REQUIRE(growth);
  CHECK(map_bytes_at(*growth, SensorTime{99}) == 0);
  CHECK(map_bytes_at(*growth, SensorTime{100}) == 1000);
  CHECK(map_bytes_at(*growth, SensorTime{299}) == 3000);
  CHECK(map_bytes_at(*growth, SensorTime{900}) == 2000);
}

TEST_CASE("the last third's growth compares the end with two thirds of the mission") {
  std::vector<MapSize> growth;
  for (int k = 0; k <= 30; ++k) growth.push_back({SensorTime{k}, 1, k <= 20 ? 100 : 100 + k - 20});
  CHECK(growth_in_last_third(growth) == doctest::Approx(0.10));
  CHECK(growth_in_last_third({}) == 0.0);
}

/// Two rooms side by side, then a third above the second; a way at one pose a second.
GroundTruth make_truth(const std::vector<Eigen::Vector3d>& way) {
  GroundTruth truth;
  truth.rooms.push_back({0, "A", 0, {0, 0, 0}, {4, 4, 3}});
  truth.rooms.push_back({1, "stairwell", 0, {4, 0, 0}, {8, 4, 3}});
  truth.rooms.push_back({2, "upper", 1, {4, 0, 3}, {8, 4, 6}});
  for (std::size_t k = 0; k < way.size(); ++k) {
    truth.T_W_L.push_back({SensorTime{static_cast<std::int64_t>(k) * 1'000'000'000},
                           make_pose(way[k], Eigen::Quaterniond::Identity())});
  }
  return truth;
}

TEST_CASE("a round ends nearest to the first room's middle once all others were seen") {
  const Eigen::Vector3d middle(2, 2, 1.5), edge(3.5, 2, 1.5), stairs(6, 2, 1.5), upper(6, 2, 4.5);
  const GroundTruth truth =
      make_truth({middle, edge, stairs, edge, middle,               // no round: not upstairs
                  edge, stairs, upper, stairs, edge, middle, edge,  // the first
                  stairs, upper, stairs, edge, middle});            // the second
  const auto ends = round_ends(truth);
  REQUIRE(ends.size() == 2);
  CHECK(ends[0] == truth.T_W_L[10].stamp);
  CHECK(ends[1] == truth.T_W_L[16].stamp);
  CHECK(round_ends(make_truth({middle, stairs, middle})).empty());
}

TEST_CASE("the six rounds of the small rooms are found") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto world = make_world("small-rooms", seed);
    REQUIRE(world);
    const Trajectory way = walk(world->path, {}, SensorTime{0}, seed);
    GroundTruth truth;
    truth.rooms = world->rooms;
    for (std::size_t k = 0; k < way.poses.size(); ++k)
      truth.T_W_L.push_back({way.stamp(k), way.poses[k]});
    CAPTURE(seed);
    const auto ends = round_ends(truth);
    REQUIRE(ends.size() == 6);
    const double round_s = (way.end() - way.start).seconds() / 6.0;
    for (int k = 0; k < 6; ++k) {
      const double end_s = (ends[static_cast<std::size_t>(k)] - way.start).seconds();
      CHECK(end_s == doctest::Approx(round_s * (k + 1)).epsilon(0.1));
    }
  }
}

TEST_CASE("a submap lies across storeys when it holds scans of rooms on two, stairs left out") {
  const GroundTruth truth = make_truth({{2, 2, 1.5}, {6, 2, 1.5}, {6, 2, 4.5}});
  const auto stamp = [&](std::size_t k) { return truth.T_W_L[k].stamp; };
  CHECK(submaps_across_storeys(truth, {{0, {stamp(0), stamp(1)}}, {1, {stamp(1), stamp(2)}}}) == 0);
  CHECK(submaps_across_storeys(truth, {{0, {stamp(0), stamp(1), stamp(2)}}}) == 1);
}

/// A level sheet of 10 x 10 m that is seen from above.
void add_sheet(float z, TriangleMesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (const auto& [x, y] : {std::pair{0.0F, 0.0F}, {10.0F, 0.0F}, {10.0F, 10.0F}, {0.0F, 10.0F}})
    mesh->vertices.emplace_back(x, y, z);
  mesh->triangles.push_back({first, first + 1, first + 2});
  mesh->triangles.push_back({first, first + 2, first + 3});
}

/// @param error  how far the mission's graph has all of it aside
DoubledSurface doubled(const TriangleMesh& mesh, const TriangleMesh& truth,
                       const Eigen::Vector3d& error = Eigen::Vector3d::Zero()) {
  const auto scene = RayScene::build(truth);
  REQUIRE(scene);
  Pose aside = Pose::Identity();
  aside.translation() = error;
  const std::vector<StampedPose> T_M_L{{{0}, aside}}, T_W_L{{{0}, Pose::Identity()}};
  const auto found = find_doubled_surface(mesh, LocalAlignment(T_M_L, T_W_L), *scene, 2000, 1);
  REQUIRE(found);
  CHECK(found->samples == 2000);
  return *found;
}

TEST_CASE("two sheets where the truth has one are doubled, wherever between them it lies") {
  for (const float truth_z : {0.0F, 0.1F, 0.2F}) {
    TriangleMesh truth, mesh;
    add_sheet(truth_z, &truth);
    add_sheet(0.0F, &mesh);
    add_sheet(0.2F, &mesh);
    CAPTURE(truth_z);
    CHECK(doubled(mesh, truth).share() > 0.99);
    CHECK(doubled(mesh, truth).far_share() > 0.99);
  }
}

TEST_CASE("sheets in neighbouring voxels are doubled, but not far apart") {
  TriangleMesh truth, mesh;
  add_sheet(0.0F, &truth);
  add_sheet(0.0F, &mesh);
  add_sheet(0.065F, &mesh);
  CHECK(doubled(mesh, truth).share() > 0.99);
  CHECK(doubled(mesh, truth).far == 0);
}

TEST_CASE("two sheets are not doubled where the truth has two, too near, too far, or faced apart") {
  TriangleMesh truth;
  add_sheet(0.0F, &truth);
  for (const float z : {0.04F, 0.51F}) {
    TriangleMesh mesh = truth;
    add_sheet(z, &mesh);
    CAPTURE(z);
    CHECK(doubled(mesh, truth).doubled == 0);
  }
  TriangleMesh two = truth;
  add_sheet(0.2F, &two);
  CHECK(doubled(two, two).doubled == 0);
  TriangleMesh apart = two;
  for (std::size_t k = 2; k < 4; ++k) std::swap(apart.triangles[k][0], apart.triangles[k][1]);
  CHECK(doubled(apart, truth).doubled == 0);
}

TEST_CASE("what a graph has put aside is not doubled for that, and what is doubled stays so") {
  TriangleMesh blinds, aside, wall;
  add_sheet(0.0F, &wall);
  for (const float z : {0.0F, 0.2F}) {
    add_sheet(z, &blinds);
    add_sheet(z + 0.1F, &aside);
  }
  CHECK(doubled(aside, blinds).share() > 0.99);
  CHECK(doubled(aside, blinds, {0, 0, 0.1}).doubled == 0);
  CHECK(doubled(aside, wall, {0, 0, 0.1}).share() > 0.99);
  CHECK(doubled(aside, wall, {0, 0, 0.2}).share() > 0.99);
}

TEST_CASE("a pair's doubt is the root of its largest variance") {
  std::string row = "3,9";
  for (int k = 0; k < 36; ++k) row += ",0";
  const auto doubts = parse_doubts_m("head\n" + row + ",0.01,0.02,0.25\n", "doubts.csv");
  REQUIRE(doubts);
  REQUIRE(doubts->size() == 1);
  CHECK(doubts->front() == doctest::Approx(0.5));
  CHECK(!parse_doubts_m("head\n1,2,3\n", "doubts.csv"));
}

TEST_CASE("pairs without a question to ask need no program") {
  const auto doubts = ask_doubts_m("no-such-program", "", "", {{4, 4}, {-1, 2}});
  REQUIRE(doubts);
  CHECK((*doubts)[0] == 0.0);
  CHECK(std::isinf((*doubts)[1]));
}

Experiment make_experiment() {
  Experiment e;
  e.world = "small-rooms";
  for (std::int64_t k = 1; k <= 6; ++k) {
    e.ours.growth.push_back({SensorTime{k * 60'000'000'000}, k, 1'000'000 + 10'000 * k});
    e.round_ends.push_back({k * 60'000'000'000});
  }
  e.baseline.growth = e.ours.growth;
  e.ours.submaps_final = 9;
  e.ours.map_bytes_final = 40;
  e.baseline.map_bytes_final = 100;
  e.rand_index = 0.79;
  e.mesh = {0.5, 0.97, 1.0};
  e.returns = {0.6, 1.0, 1.0};
  e.doubled_share = 0.01;
  return e;
}

std::string verdict(const Experiment& e, const std::string& what) {
  for (const Line& line : judge_lines(e)) {
    if (line.what == what) return line.verdict;
  }
  return "no such line";
}

TEST_CASE("figures on their limits pass, and those past them fail") {
  Experiment e = make_experiment();
  CHECK(verdict(e, "submaps at the end") == "PASS");
  CHECK(verdict(e, "adjusted Rand index") == "FAIL");
  CHECK(verdict(e, "memory saved at the end") == "PASS");
  CHECK(verdict(e, "map after round 6") == "PASS");
  CHECK(verdict(e, "10 cm: mesh against perfect") == "PASS");
  CHECK(verdict(e, "surface drawn twice") == "FAIL");
  e.is_cut_short = true;
  e.ours.submaps_final = 19;
  CHECK(verdict(e, "submaps at the end") == "FAIL*");
  e.ours.growth[5].bytes = 1'100'000;
  CHECK(verdict(e, "map after round 6") == "FAIL");
}

TEST_CASE("what is fused across a wrong loop closure that admits its doubt is a miss") {
  Experiment e = make_experiment();
  e.fused_across = 1;
  CHECK(verdict(e, "fused across one") == "no such line");
  e.fault = GraphFault::kDoubtedClosures;
  CHECK(verdict(e, "fused across one") == "FAIL");
  e.fused_across = 0;
  CHECK(verdict(e, "fused across one") == "PASS");
  CHECK(experiment_name(e) == "small-rooms_1_doubted-closures");
  e.clouds = CloudKind::kGathered;
  CHECK(experiment_name(e) == "small-rooms_1_doubted-closures_gathered");
}

TEST_CASE("the results file has as many cells in every row as in its head") {
  const std::string csv =
      format_csv({make_experiment(), make_experiment()}, {"2020-01-01", "a, machine", "abc"});
  std::vector<std::ptrdiff_t> commas;
  for (std::size_t begin = 0; begin < csv.size();) {
    const std::size_t end = csv.find('\n', begin);
    commas.push_back(std::count(csv.begin() + static_cast<std::ptrdiff_t>(begin),
                                csv.begin() + static_cast<std::ptrdiff_t>(end), ','));
    begin = end + 1;
  }
  REQUIRE(commas.size() == 3);
  CHECK(commas[1] == commas[0]);
  CHECK(commas[2] == commas[0]);
}

TEST_CASE("a long timeline's plot stays short and keeps its peak") {
  Experiment e = make_experiment();
  e.ours.growth.clear();
  for (std::int64_t k = 0; k < 30'000; ++k)
    e.ours.growth.push_back({SensorTime{k * 100'000'000}, 1, k == 777 ? 4'000'000 : 1'000'000});
  const std::string svg = growth_plot_svg(e);
  CHECK(svg.size() < 40'000);
  CHECK(svg.find(",40.0 ") != std::string::npos);  // the top of the upper chart
  CHECK(svg.ends_with("</svg>\n"));
}

}  // namespace
}  // namespace cloister
