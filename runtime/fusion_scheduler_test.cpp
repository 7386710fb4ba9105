#include "runtime/fusion_scheduler.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <doctest/doctest.h>

#include "mapping/fuse/walls_for_tests.hpp"
#include "mapping/graph/row_of_nodes_for_tests.hpp"
#include "runtime/overlap_worker.hpp"

namespace cloister {
namespace {

/// The scheduler and its worker. The test is the integration thread and the reader.
struct Scheduling {
  Scheduling() { map.pools().take_all(); }

  /// A finished submap with rows of 4 x 4 blocks, half of each occupied so that walls run along x, and a path along them.
  Submap* finished(SubmapId id, NodeId root, float path_z_m,
                   std::initializer_list<std::pair<int, int>> x_ranges, int path_end) {
    Submap* submap = &slots[static_cast<std::size_t>(id)];
    submap->id = id;
    Pose T_root_S = Pose::Identity();
    T_root_S.translation().x() = -2.0 * static_cast<double>(root);
    submap->bind(root, T_root_S);
    for (const auto& [begin, end] : x_ranges) {
      for (int x = begin; x < end; ++x) {
        add_half_walls(x, map.pools(), submap->volume);
        if (x < path_end)
          submap->path.add({(static_cast<float>(x) + 0.5f) * 0.52f, 0.4f, path_z_m});
      }
    }
    totals.bytes.fetch_add(static_cast<std::int64_t>(submap->volume.bytes()));
    totals.count.fetch_add(1);
    return submap;
  }

  Config config;
  VoxelStore store{4'000, 400};
  ElasticMap map{config, store};
  std::array<Submap, 3> slots;
  SpscQueue<SchedulerCommand> commands{16};
  SpscQueue<MapReturn> returns{256};
  SpscQueue<const GraphRevision*> retired{16};
  SpscQueue<OverlapBatch*> requests{2}, answers{2};
  Doorbell bell, worker_bell, integration_bell, reader_bell;
  FinishedTotals totals;
};

TEST_CASE("a remnant joins its heir in the same command, and the totals are those of the map") {
  const GraphRevision graph = with_loop(row_of_nodes(1e6, 3), 0, 2, 1e6);

  Scheduling s;
  // Of the twelve rows that the first one knows, one has all but the last six, and another five of those: less than makes a
  // fusion, for each knows other places as well. The first one's path is a little further from everything.
  const std::array finished = {s.finished(0, 0, 0.02f, {{3, 15}}, 4),
                               s.finished(1, 1, 0.1f, {{-4, 9}}, 9),
                               s.finished(2, 2, 0.1f, {{9, 14}, {16, 24}}, 24)};
  {
    OverlapWorker worker(s.store, s.config.voxel.voxel_size_m, 1, s.requests, s.answers,
                         s.worker_bell, s.bell);
    FusionScheduler scheduler(s.map, 0.1, s.slots.size(),
                              {s.commands, s.returns, s.retired, s.requests, s.answers, s.bell,
                               s.worker_bell, s.integration_bell, s.reader_bell, s.totals});
    REQUIRE(s.commands.try_push({{}, nullptr, &graph}));
    for (Submap* submap : finished) REQUIRE(s.commands.try_push({{}, submap, nullptr}));
    scheduler.stop();
    CHECK(scheduler.record().accepted == 1);
    CHECK(scheduler.record().blocks_shared == 11 * 16);
    CHECK(std::any_of(scheduler.record().events.begin(), scheduler.record().events.end(),
                      [](const Event& event) {
                        return event.kind == EventKind::kFusionAccepted && event.reason == "remnant";
                      }));
  }
  CHECK(s.map.submaps().size() == 2);
  CHECK(s.totals.count.load() == 2);
  CHECK(s.map.find(1) == finished[1]);
  CHECK(s.totals.bytes.load() == s.map.bytes());
}

}  // namespace
}  // namespace cloister
