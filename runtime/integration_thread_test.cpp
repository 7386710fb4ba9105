#include "runtime/integration_thread.hpp"

#include <array>
#include <deque>
#include <vector>

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

TEST_CASE("back in a known place the active submap goes to be fused, and scans wait for nobody") {
  Walk walk;
  walk.send_scan(0, -3, 3, 0);
  CHECK(walk.next_report().outcome.submap == 0);
  std::vector<SubmapId> submaps;
  for (int x = 20; x >= 1; --x) {
    walk.send_scan(x, -6, 26, 1);
    // Nothing has come back from the scheduler.
    const ScanReport report = walk.next_report();
    submaps.push_back(report.outcome.submap);
    if (x == 1) CHECK(report.outcome.spawned == SpawnReason::kReturn);
  }
  std::vector<SubmapId> expected(19, 1);
  expected.push_back(2);
  CHECK(submaps == expected);
  CHECK(walk.finished.count == 2);
  std::vector<SubmapId> handed_over;
  for (SchedulerCommand command; walk.scheduler.try_pop(command);) {
    if (command.finished != nullptr) handed_over.push_back(command.finished->id);
  }
  CHECK(handed_over == std::vector<SubmapId>{0, 1});
}

}  // namespace
}  // namespace cloister
