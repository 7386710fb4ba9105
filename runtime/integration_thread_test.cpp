#include "runtime/integration_thread.hpp"

#include <array>
#include <deque>

#include <doctest/doctest.h>

namespace cloister {
namespace {

/// A corridor along x, walked by a sensor that stands by the node at its beginning, is 20 m away by the next, and comes back.
/// The test is the reader and the fusion scheduler.
struct Walk {
  Walk() {
    mapper.pools().take_all();
    for (Submap& slot : slots) mapper.give_slot(&slot);
    T_M_far.translation().x() = 20;
    revision.graph.nodes = {{0, {100'000'000}, true, Pose::Identity()},
                            {1, {300'000'000}, true, T_M_far}};
    revision.T_O_N = {Pose::Identity(), T_M_far};
    send({{}, &revision});
  }
  ~Walk() { thread.stop(); }

  void send(const IntegrationCommand& command) {
    REQUIRE(commands.try_push(command));
    bell.ring();
  }
  /// A scan of the corridor from `x0` to `x1`, taken at `x` in M.
  void send_scan(double x, double x0, double x1, NodeId node) {
    Scan& scan = scans.emplace_back();
    scan.kind = Scan::Kind::kCloud;
    scan.stamp = {static_cast<std::int64_t>(scans.size()) * 100'000'000};
    for (double along = x0; along <= x1; along += 0.12) {
      for (double z = 0; z <= 2.5; z += 0.12) {
        for (const double y : {-3.0, 3.0})
          scan.points_L.push_back(Eigen::Vector3d{along - x, y, z - 0.5}.cast<float>());
      }
    }
    Pose T_O_L = Pose::Identity();
    T_O_L.translation() = Eigen::Vector3d{x, 0, 0.5};
    scan.T_O_L = T_O_L;
    scan.node = node;
    scan.poses = {{scan.stamp, node == 0 ? T_O_L : T_M_far.inverse() * T_O_L}};
    send({{&scan, {}}, nullptr});
  }
  ScanReport next_report() {
    ScanReport report;
    for (std::uint32_t seen = reader_bell.count(); !reports.try_pop(report);
         seen = reader_bell.count())
      reader_bell.wait(seen);
    return report;
  }
  /// Walks until the active submap is closed to join the place where the sensor is back. @return that submap
  Submap* come_back() {
    send_scan(0, -3, 3, 0);
    CHECK(next_report().outcome.submap == 0);
    bool is_back = false;
    for (int x = 20; !is_back && x >= 0; --x) {
      send_scan(x, -6, 26, 1);
      const ScanReport report = next_report();
      CHECK(report.outcome.submap == 1);
      is_back = report.outcome.is_known_place;
    }
    REQUIRE(is_back);
    SchedulerCommand command;
    while (!command.give_back) REQUIRE(scheduler.try_pop(command));
    return command.finished;
  }
  void give_back(Submap* fused) {
    MapReturn item{};
    item.fused = fused;
    REQUIRE(returns.try_push(item));
    bell.ring();
  }

  Config config;
  VoxelStore store{20'000, 2'000};
  std::array<Submap, 4> slots;
  Pose T_M_far = Pose::Identity();
  GraphRevision revision;
  std::deque<Scan> scans;
  SpscQueue<IntegrationCommand> commands{8};
  SpscQueue<MapReturn> returns{8};
  SpscQueue<ScanReport> reports{64};
  SpscQueue<SchedulerCommand> scheduler{64};
  Doorbell bell, scheduler_bell, reader_bell;
  FinishedTotals finished;
  LocalMapper mapper{(config.memory.max_submaps = 4, config.spawn.return_travel_m = 1,
                      config.spawn.max_travel_m = 0, config),
                     store};
  IntegrationThread thread{
      mapper,
      {commands, returns, reports, scheduler, bell, scheduler_bell, reader_bell, finished},
      nullptr};
};

TEST_CASE("scans that come while the active submap joins a known place go on in what comes back") {
  Walk walk;
  Submap* closed = walk.come_back();
  REQUIRE(closed != nullptr);
  for (int i = 0; i < 3; ++i) walk.send_scan(0, -6, 26, 1);
  CHECK(walk.reports.depth() == 0);
  walk.give_back(closed);
  for (int i = 0; i < 3; ++i) {
    const ScanReport report = walk.next_report();
    CHECK(report.outcome.submap == 1);
    CHECK(report.outcome.spawned == SpawnReason::kNone);
    CHECK_FALSE(report.is_before_fusion);
  }
}

TEST_CASE(
    "where half the queue waits for it, they go on in a submap of their own, and that is told "
    "once") {
  Walk walk;
  Submap* closed = walk.come_back();
  REQUIRE(closed != nullptr);
  for (int i = 0; i < 4; ++i) walk.send_scan(0, -6, 26, 1);
  const ScanReport first = walk.next_report();
  CHECK(first.outcome.submap == 2);
  CHECK(first.outcome.spawned == SpawnReason::kLoopClosure);
  CHECK(first.is_before_fusion);
  walk.send_scan(0, -6, 26, 1);
  const ScanReport second = walk.next_report();
  CHECK(second.outcome.submap == 2);
  CHECK_FALSE(second.is_before_fusion);
  walk.give_back(closed);
  for (int i = 0; i < 3; ++i) CHECK(walk.next_report().outcome.submap == 1);
  // What was begun meanwhile is finished, and handed over like any other.
  SchedulerCommand command;
  REQUIRE(walk.scheduler.try_pop(command));
  CHECK(command.finished->id == 2);
  CHECK_FALSE(command.give_back);
}

}  // namespace
}  // namespace cloister
