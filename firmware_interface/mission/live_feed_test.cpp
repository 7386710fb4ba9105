#include "firmware_interface/mission/live_feed.hpp"

#include <limits>

#include <doctest/doctest.h>

namespace cloister {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kMs = 1'000'000;
const LiveFeed::HostTime kStart{1000s};

Pose at_x(double x_m) {
  Pose T = Pose::Identity();
  T.translation().x() = x_m;
  return T;
}

GraphUpdate graph(std::uint64_t revision, std::int64_t stamp_ms,
                  std::vector<std::pair<NodeId, std::int64_t>> nodes,
                  std::uint64_t base_revision = 0) {
  GraphUpdate update{7, revision, base_revision, {SensorTime{stamp_ms * kMs}, {}, {}}};
  for (const auto& [id, node_ms] : nodes)
    update.graph.nodes.push_back({id, SensorTime{node_ms * kMs}, true, at_x(100)});
  return update;
}

/// A robot that moves along x at 1 m/s, seen by a feed with the usual waiting time of half a second.
struct Robot {
  LiveFeed feed{Config(), Pose::Identity(), 64, 8};
  Scan out;

  Robot() { out.reserve(64, 8, ScanPlacer::kMaxPoses); }
  void odometry(std::int64_t from_ms, std::int64_t to_ms, double shift_m = 0,
                std::uint64_t session = 1) {
    for (std::int64_t ms = from_ms; ms <= to_ms; ms += 10) {
      feed.push(OdometrySample{
          session, {SensorTime{ms * kMs}, at_x(static_cast<double>(ms) * 1e-3 + shift_m)}});
    }
  }
  void scan(std::int64_t stamp_ms, LiveFeed::HostTime now = kStart) {
    Scan& scan = feed.scan_to_fill();
    scan.kind = Scan::Kind::kOrganised;
    scan.stamp = scan.last_packet = SensorTime{stamp_ms * kMs};
    scan.ranges_mm.assign(64, 1000);
    scan.column_stamps.assign(8, SensorTime{stamp_ms * kMs});
    scan.column_valid.assign(8, 1);
    feed.push_scan(now);
  }
  LiveFeed::Item next(LiveFeed::HostTime now = kStart) { return feed.next(now, out); }
  std::uint64_t count(FeedCause cause) const { return feed.counters()[cause]; }
};

using Item = LiveFeed::Item;

TEST_CASE("a scan leaves as soon as odometry reaches it, placed where the robot was") {
  Robot robot;
  robot.odometry(0, 500);
  robot.scan(505);
  CHECK(robot.next() == Item::kNone);
  robot.odometry(510, 510);
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.stamp.ns == 505 * kMs);
  CHECK(robot.out.node == kNoNode);
  CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.505));
  CHECK(robot.next() == Item::kNone);
}

TEST_CASE("a graph leaves before the first scan that is not older, whichever came first") {
  Robot robot;
  robot.odometry(0, 1000);
  robot.scan(300);
  robot.scan(400);
  SUBCASE("the graph comes last") { robot.feed.push(graph(1, 350, {{0, 100}}), kStart); }
  SUBCASE("the graph comes in the middle of things") {
    REQUIRE(robot.next() == Item::kScan);
    robot.scan(500);
    robot.feed.push(graph(1, 350, {{0, 100}}), kStart);
    REQUIRE(robot.next() == Item::kGraph);
    REQUIRE(robot.next() == Item::kScan);
    CHECK(robot.out.node == 0);
    CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.3));
    return;
  }
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.node == kNoNode);
  REQUIRE(robot.next() == Item::kGraph);
  const auto revision = robot.feed.take_graph();
  REQUIRE(revision->T_O_N[0]);
  CHECK(revision->T_O_N[0]->translation().x() == doctest::Approx(0.1));
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.node == 0);
}

TEST_CASE("the odometry frame lies where the newest node of the graph says") {
  Robot robot;
  REQUIRE(robot.feed.T_M_O());
  CHECK(robot.feed.T_M_O()->isApprox(Pose::Identity()));
  robot.odometry(0, 1000);
  robot.scan(600);
  robot.feed.push(graph(1, 350, {{0, 100}, {1, 300}}), kStart);
  REQUIRE(robot.next() == Item::kGraph);
  // Nodes lie at 100 m; odometry was at 0.3 m at the newest of them.
  REQUIRE(robot.feed.T_M_O());
  CHECK(robot.feed.T_M_O()->translation().x() == doctest::Approx(99.7));
  robot.odometry(1010, 1020, 50, 2);
  CHECK_FALSE(robot.feed.T_M_O());
}

TEST_CASE("a graph does not wait for ever for a scan that never comes") {
  Robot robot;
  robot.odometry(0, 1000);
  robot.feed.push(graph(1, 350, {{0, 100}}), kStart);
  CHECK(robot.next(kStart + 499ms) == Item::kNone);
  CHECK(robot.next(kStart + 500ms) == Item::kGraph);
}

TEST_CASE("a scan without a pose waits a bounded time, then it is dropped and counted") {
  Robot robot;
  robot.odometry(0, 300);
  SUBCASE("odometry stopped a moment ago: the scan is placed by its last velocity") {
    robot.scan(600);
    CHECK(robot.next(kStart + 499ms) == Item::kNone);
    REQUIRE(robot.next(kStart + 500ms) == Item::kScan);
    CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.6));
  }
  SUBCASE("odometry stopped long ago") {
    robot.scan(900);
    CHECK(robot.next(kStart + 499ms) == Item::kNone);
    CHECK(robot.next(kStart + 500ms) == Item::kNone);
    CHECK(robot.count(FeedCause::kScanWithoutPose) == 1);
    CHECK(robot.feed.num_scans_dropped() == 1);
  }
  SUBCASE("more scans wait than there is room for: the oldest goes") {
    for (std::int64_t i = 0; i < 20; ++i) robot.scan(900 + i);
    CHECK(robot.feed.num_waiting_scans() == LiveFeed::kMaxWaitingScans);
    CHECK(robot.count(FeedCause::kScanWaitingTooMany) == 20 - LiveFeed::kMaxWaitingScans);
    robot.odometry(310, 1000);
    REQUIRE(robot.next() == Item::kScan);
    CHECK(robot.out.stamp.ns == 904 * kMs);
  }
}

TEST_CASE("a stamp offset brings the sensor's clock to that of odometry") {
  Config config;
  config.scan.stamp_offset_s = -0.1;
  Robot robot;
  robot.feed = LiveFeed(config, Pose::Identity(), 64, 8);
  robot.odometry(0, 500);
  robot.scan(600);
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.5));
}

TEST_CASE("a scan waits for the sensor's place on the body as it does for its pose") {
  Robot robot;
  robot.feed = LiveFeed(Config(), std::nullopt, 64, 8);
  robot.odometry(0, 500);
  robot.scan(300);
  CHECK(robot.next() == Item::kNone);
  SUBCASE("it is said in time") {
    robot.feed.set_T_B_L(at_x(2));
    REQUIRE(robot.next() == Item::kScan);
    REQUIRE(robot.out.T_O_L);
    CHECK(robot.out.T_O_L->translation().x() == doctest::Approx(2.3));
  }
  SUBCASE("it is not") {
    CHECK(robot.next(kStart + 500ms) == Item::kNone);
    CHECK(robot.count(FeedCause::kScanWithoutSensorPose) == 1);
    CHECK(robot.feed.num_scans_dropped() == 1);
  }
}

TEST_CASE("without odometry a cloud waits for the node with its stamp, whenever the graph comes") {
  Robot robot;
  robot.feed.expect_no_odometry();
  const auto cloud = [&](std::int64_t stamp_ms) {
    Scan& scan = robot.feed.scan_to_fill();
    scan.kind = Scan::Kind::kCloud;
    scan.stamp = scan.last_packet = SensorTime{stamp_ms * kMs};
    scan.points_L.assign(3, Eigen::Vector3f(1, 0, 0));
    robot.feed.push_scan(kStart);
  };
  cloud(300);
  CHECK(robot.next() == Item::kNone);
  robot.feed.push(graph(1, 900, {{0, 100}, {1, 300}}), kStart + 100ms);
  REQUIRE(robot.next(kStart + 100ms) == Item::kGraph);
  REQUIRE(robot.next(kStart + 100ms) == Item::kScan);
  CHECK(robot.out.node == 1);
  CHECK(robot.feed.num_returns_read() == 3);
  cloud(700);  // no node ever gets its stamp
  CHECK(robot.next(kStart + 499ms) == Item::kNone);
  CHECK(robot.next(kStart + 500ms) == Item::kNone);
  CHECK(robot.count(FeedCause::kScanWithoutPose) == 1);
}

TEST_CASE("scans that repeat or go back are dropped and counted") {
  Robot robot;
  robot.odometry(0, 500);
  robot.scan(300);
  robot.scan(300);
  robot.scan(200);
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.next() == Item::kNone);
  CHECK(robot.count(FeedCause::kScanOutOfOrder) == 2);
}

TEST_CASE(
    "odometry that runs backwards, is nowhere or leaps for one sample is dropped and counted") {
  Robot robot;
  robot.odometry(0, 500);
  robot.odometry(200, 290);
  CHECK(robot.count(FeedCause::kOdometryBackwards) == 10);
  Pose nowhere = Pose::Identity();
  nowhere.translation().y() = std::numeric_limits<double>::quiet_NaN();
  robot.feed.push(OdometrySample{1, {SensorTime{505 * kMs}, nowhere}});
  CHECK(robot.count(FeedCause::kOdometryMalformed) == 1);
  robot.odometry(510, 510, /*shift_m=*/50);
  robot.odometry(520, 1000);
  CHECK(robot.count(FeedCause::kOdometryOutlier) == 1);
  CHECK(robot.count(FeedCause::kOdometryRestart) == 0);
  robot.scan(515);
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.515));
}

TEST_CASE(
    "odometry that jumps for good places nothing wrongly: scans wait for a node that ties it to "
    "the map") {
  Robot robot;
  robot.odometry(0, 500);
  robot.scan(300);
  robot.feed.push(graph(1, 250, {{0, 100}}), kStart);
  REQUIRE(robot.next() == Item::kGraph);
  REQUIRE(robot.next() == Item::kScan);

  bool is_told = false;
  SUBCASE("it leaps") {}
  SUBCASE("another run of it says so, and begins where the old one was") { is_told = true; }
  robot.odometry(510, 1000, is_told ? 0 : 50, is_told ? 2 : 1);
  CHECK(robot.count(FeedCause::kOdometryRestart) == 1);
  robot.scan(700);
  CHECK(robot.next() == Item::kNone);
  CHECK(robot.next(kStart + 500ms) == Item::kNone);
  CHECK(robot.count(FeedCause::kScanWithoutNode) == 1);

  robot.scan(800);
  robot.feed.push(graph(2, 760, {{0, 100}, {1, 750}}), kStart);
  REQUIRE(robot.next() == Item::kGraph);
  const auto revision = robot.feed.take_graph();
  CHECK(revision->T_O_N[0].has_value());
  // What was mapped before any graph lies in the first frame: a pose in the second one would misplace it.
  CHECK_FALSE(revision->T_O_N[1].has_value());
  REQUIRE(robot.next() == Item::kScan);
  CHECK(robot.out.node == 1);
  CHECK(robot.out.poses.back().T_R_L.translation().x() == doctest::Approx(0.05));
}

TEST_CASE("graph updates that do not fit are refused and counted, and leave the graph as it was") {
  GraphKeeper keeper(0);
  REQUIRE(keeper.apply(graph(3, 100, {{2, 20}, {0, 0}, {1, 10}})) == GraphCause::kApplied);
  CHECK(keeper.graph().nodes[2].id == 2);
  CHECK(keeper.apply(graph(3, 100, {{5, 0}})) == GraphCause::kRepeated);
  CHECK(keeper.apply(graph(2, 90, {{5, 0}})) == GraphCause::kRepeated);
  CHECK(keeper.apply(graph(6, 120, {{5, 0}}, /*base_revision=*/5)) == GraphCause::kOutOfOrder);
  CHECK(keeper.apply(graph(4, 110, {})) == GraphCause::kMalformed);
  CHECK(keeper.apply(graph(4, 110, {{1, 0}, {1, 0}})) == GraphCause::kMalformed);
  GraphUpdate stranger = graph(9, 200, {{0, 0}});
  stranger.session = 8;
  CHECK(keeper.apply(stranger) == GraphCause::kOtherSession);
  GraphUpdate nowhere = graph(4, 110, {{0, 0}});
  nowhere.graph.nodes[0].T_M_N.translation().x() = std::numeric_limits<double>::infinity();
  CHECK(keeper.apply(nowhere) == GraphCause::kMalformed);
  CHECK(keeper.graph().nodes.size() == 3);
  CHECK(keeper.revision() == 3);
}

TEST_CASE("an increment adds and moves nodes, adds edges, and renews those it repeats") {
  GraphKeeper keeper(0);
  GraphUpdate whole = graph(1, 100, {{0, 0}, {1, 10}});
  whole.graph.edges.push_back({0, 1, at_x(1), Matrix6d::Identity(), true});
  REQUIRE(keeper.apply(whole) == GraphCause::kApplied);
  GraphUpdate increment = graph(2, 200, {{1, 10}, {2, 20}}, /*base_revision=*/1);
  increment.graph.nodes[0].T_M_N = at_x(5);
  increment.graph.edges.push_back({1, 2, at_x(1), Matrix6d::Identity(), true});
  increment.graph.edges.push_back({0, 1, at_x(1), 2 * Matrix6d::Identity(), true});
  REQUIRE(keeper.apply(increment) == GraphCause::kApplied);
  REQUIRE(keeper.graph().nodes.size() == 3);
  CHECK(keeper.graph().nodes[1].T_M_N.translation().x() == 5);
  REQUIRE(keeper.graph().edges.size() == 2);
  CHECK(keeper.graph().edges[0].information(0, 0) == 2);
}

TEST_CASE("edges that name unknown nodes, themselves or no information are left out and counted") {
  GraphKeeper keeper(0);
  GraphUpdate update = graph(1, 100, {{0, 0}, {1, 10}});
  update.graph.edges.push_back({0, 9, at_x(1), Matrix6d::Identity(), true});
  update.graph.edges.push_back({1, 1, at_x(1), Matrix6d::Identity(), true});
  update.graph.edges.push_back({0, 1, at_x(1), Matrix6d::Identity(), false});
  update.graph.edges.push_back({0, 1, at_x(1), Matrix6d::Identity(), true});
  REQUIRE(keeper.apply(update) == GraphCause::kApplied);
  CHECK(keeper.graph().edges.size() == 1);
  CHECK(keeper.counters()[GraphCause::kEdgeOfUnknownNode] == 1);
  CHECK(keeper.counters()[GraphCause::kEdgeMalformed] == 1);
  CHECK(keeper.counters()[GraphCause::kEdgeWithoutInformation] == 1);

  GraphKeeper lenient(/*default_information=*/4);
  REQUIRE(lenient.apply(update) == GraphCause::kApplied);
  REQUIRE(lenient.graph().edges.size() == 2);
  CHECK(lenient.graph().edges[0].information(5, 5) == 4);
}

}  // namespace
}  // namespace cloister
