#include "runtime/integration_thread.hpp"

#include <array>
#include <deque>
#include <vector>

#include <doctest/doctest.h>

namespace cloister {
namespace {

/// A sensor that walks down a corridor, along x. The test is the reader and the fusion scheduler.
struct Walk {
  Walk() {
    mapper.pools().take_all();
    for (Submap& slot : slots) mapper.give_slot(&slot);
  }
  ~Walk() { thread.stop(); }

  void send_scan(double x) {
    Scan& scan = scans.emplace_back();
    scan.kind = Scan::Kind::kCloud;
    scan.stamp = {static_cast<std::int64_t>(scans.size()) * 100'000'000};
    for (double along = -6; along <= 26; along += 0.12) {
      for (double z = 0; z <= 2.5; z += 0.12) {
        for (const double y : {-3.0, 3.0})
          scan.points_L.push_back(Eigen::Vector3d{along - x, y, z - 0.5}.cast<float>());
      }
    }
    Pose T_O_L = Pose::Identity();
    T_O_L.translation() = Eigen::Vector3d{x, 0, 0.5};
    scan.T_O_L = T_O_L;
    scan.poses = {{scan.stamp, T_O_L}};
    REQUIRE(commands.try_push({{&scan, {}}, nullptr}));
    bell.ring();
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
  std::deque<Scan> scans;
  SpscQueue<IntegrationCommand> commands{8};
  SpscQueue<MapReturn> returns{8};
  SpscQueue<ScanReport> reports{64};
  SpscQueue<SchedulerCommand> scheduler{64};
  Doorbell bell, scheduler_bell, reader_bell;
  FinishedTotals finished;
  LocalMapper mapper{(config.memory.max_submaps = 4, config.spawn.max_travel_m = 5, config), store};
  IntegrationThread thread{
      mapper,
      {commands, returns, reports, scheduler, bell, scheduler_bell, reader_bell, finished},
      nullptr};
};

TEST_CASE("a submap that is long enough goes to be fused, and scans wait for nobody") {
  Walk walk;
  std::vector<SubmapId> submaps;
  for (int x = 0; x <= 12; ++x) {
    walk.send_scan(x);
    // Nothing ever comes back from the scheduler.
    const ScanReport report = walk.next_report();
    submaps.push_back(report.outcome.submap);
    CHECK((report.outcome.spawned == SpawnReason::kDistance) == (x == 5 || x == 10));
  }
  CHECK(submaps == std::vector<SubmapId>{0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2});
  CHECK(walk.finished.count == 2);
  for (const SubmapId id : {0, 1}) {
    SchedulerCommand command;
    REQUIRE(walk.scheduler.try_pop(command));
    REQUIRE(command.finished != nullptr);
    CHECK(command.finished->id == id);
  }
  CHECK(walk.scheduler.depth() == 0);
}

}  // namespace
}  // namespace cloister
