#include "mapping/fuse/elastic_map.hpp"

#include <algorithm>
#include <array>

#include <doctest/doctest.h>

#include "mapping/fuse/walls_for_tests.hpp"
#include "mapping/graph/row_of_nodes_for_tests.hpp"

namespace cloister {
namespace {

struct Fixture {
  explicit Fixture(const Config& settings = {})
      : config(settings), store(4000, 400), map(config, store) {
    map.pools().take_all();
  }

  /// A finished submap with a row of 4 x 4 blocks at `x_blocks` in M, each half occupied so that walls run along x, and its
  /// path between the first two of them; rooted at `root`.
  Submap* finished(SubmapId id, NodeId root, int x_blocks) {
    Submap* submap = &slots[static_cast<std::size_t>(id)];
    submap->id = id;
    submap->T_M_S = Pose::Identity();
    Pose T_root_S = Pose::Identity();
    T_root_S.translation().x() = -2.0 * static_cast<double>(root);
    submap->bind(root, T_root_S);
    submap->path.add({(static_cast<float>(x_blocks) + 0.5f) * 0.52f, 0.4f, 0.1f});
    add_wall(*submap, x_blocks);
    return submap;
  }
  void add_wall(Submap& submap, int x_blocks) { add_half_walls(x_blocks, map.pools(), submap.volume); }
  /// Ten rows more for both, along which only `nearer` walked; `further` stays a little further from everything.
  void walk_on(Submap& further, Submap& nearer) {
    further.path.clear();
    further.path.add({3.5f * 0.52f, 0.4f, 0.02f});
    for (int x = 4; x < 14; ++x) {
      add_wall(further, x);
      add_wall(nearer, x);
      nearer.path.add({(static_cast<float>(x) + 0.5f) * 0.52f, 0.4f, 0.1f});
    }
  }
  /// Everything the scheduler does until nothing is left to do. Returns the number of fusions.
  int settle() {
    int num_fused = 0;
    while (true) {
      for (PairCheck& check : map.plan_checks()) {
        ++num_checks;
        check.overlap = voxel_overlap(store, check.a->volume, check.b->volume, check.T_b_a,
                                      config.voxel.voxel_size_m);
        map.record(check);
      }
      const auto candidate = map.next_candidate();
      if (!candidate) return num_fused;
      last_judgement = map.judge(*candidate);
      num_judged += 1;
      if (last_judgement.is_accepted) num_fused += map.fuse(*candidate, T_b_a(*candidate)) != nullptr;
    }
  }
  Pose T_b_a(const FusionCandidate& pair) const {
    return map.find(pair.b)->T_M_S.inverse() * map.find(pair.a)->T_M_S;
  }
  Config config;
  VoxelStore store;
  ElasticMap map;
  std::array<Submap, 8> slots;
  int num_checks = 0;
  int num_judged = 0;
  Judgement last_judgement;
};

TEST_CASE("two submaps of one place are fused and the memory of one is returned") {
  Fixture f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 0, 3));
  f.map.add(f.finished(1, 9, 3));
  const std::size_t free_blocks = f.map.pools().blocks.num_free();
  CHECK(f.settle() == 1);
  CHECK(f.map.submaps().size() == 1);
  CHECK(f.map.survivor(1) == 0);
  CHECK(f.map.submaps()[0]->merged_from == std::vector<SubmapId>{1});
  CHECK(f.map.pools().blocks.num_free() == free_blocks + 16);
}

TEST_CASE("a submap and its path go where a fusion lays them, whatever the graph says") {
  Fixture f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  Submap* into = f.finished(0, 0, 3);
  f.map.add(into);
  f.map.add(f.finished(1, 9, 3));
  Pose T_b_a = Pose::Identity();
  T_b_a.translation() = Eigen::Vector3d(-0.65, 1.3, 0);
  CHECK(f.map.fuse({0, 1, true, {}}, T_b_a) != nullptr);
  const Eigen::Vector3f moved = into->path.points()[1] - into->path.points()[0];
  CHECK(moved.isApprox(Eigen::Vector3f(0.65f, -1.3f, 0), 1e-4f));
}

TEST_CASE("before two submaps are fused their surfaces are laid on each other, if they are of one place") {
  Config config;
  VoxelStore store(6000, 200);
  ElasticMap map(config, store);
  map.pools().take_all();
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  map.set_graph(&graph);
  std::array<Submap, 3> slots;
  const auto add = [&](SubmapId id, NodeId root, const Pose& T_W_S) {
    Submap& submap = slots[static_cast<std::size_t>(id)];
    submap.id = id;
    Pose T_root_S = Pose::Identity();
    T_root_S.translation().x() = -2.0 * static_cast<double>(root);
    submap.bind(root, T_root_S);
    submap.volume = view_of_walls(tilted_room(), T_W_S, map.pools(), config.voxel.voxel_size_m);
    map.add(&submap);
  };
  // The graph has all three at the origin.
  const Pose aside = make_pose({0.14, -0.1, 0.03}, Eigen::Quaterniond::Identity());
  add(0, 0, Pose::Identity());
  add(1, 9, aside);
  add(2, 9, make_pose({0.9, 0.6, 0}, Eigen::Quaterniond(0.95, 0, 0, 0.3)));
  const auto known_to = [](double sigma_m) {
    return Judgement{.is_accepted = true, .sigma_m = std::array{0.01, 0.01, sigma_m}};
  };
  const auto agreed = map.agree({0, 1, true, {}}, known_to(0.04));
  REQUIRE(agreed.has_value());
  CHECK((agreed->T_b_a.translation() + aside.translation()).norm() < 0.03);
  CHECK_FALSE(map.agree({0, 2, true, {}}, known_to(0.04)).has_value());
  // 0.18 m is more than a graph may be wrong that gives itself a centimetre or two.
  CHECK_FALSE(map.agree({0, 1, true, {}}, known_to(0.02)).has_value());
}

TEST_CASE("two paths that do not see each other stay apart, unless one goes on where the other had become too long") {
  for (const SubmapId continues : {kNoSubmap, SubmapId{0}}) {
    CAPTURE(continues);
    Fixture f;
    const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
    f.map.set_graph(&graph);
    f.map.add(f.finished(0, 0, 3));
    Submap* behind = f.finished(2, 9, 3);
    behind->continues = continues;
    behind->path.clear();
    behind->path.add({3.5f * 0.52f, 1.4f, 0.1f});  // between the third wall and the fourth
    f.map.add(behind);
    CHECK(f.settle() == (continues == 0 ? 1 : 0));
  }
}

TEST_CASE("what goes on joins what the one before has become, before it is held against other places") {
  Fixture f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 0, 3));
  f.map.add(f.finished(1, 9, 3));
  REQUIRE(f.settle() == 1);
  // What it knows is half of the one before, and half of another place that it overlaps as much.
  Submap* next = f.finished(2, 9, 3);
  f.add_wall(*next, 4);
  next->continues = 1;
  f.map.add(next);
  f.map.add(f.finished(3, 0, 4));
  for (PairCheck& check : f.map.plan_checks()) {
    check.overlap = voxel_overlap(f.store, check.a->volume, check.b->volume, check.T_b_a,
                                  f.config.voxel.voxel_size_m);
    f.map.record(check);
  }
  const auto candidate = f.map.next_candidate();
  REQUIRE(candidate.has_value());
  CHECK(candidate->a == 0);
  CHECK(candidate->b == 2);
  CHECK(candidate->goes_on);
}

TEST_CASE("submaps of different places are not even compared") {
  Fixture f;
  const GraphRevision graph = row_of_nodes(1e6);
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 0, 3));
  f.map.add(f.finished(1, 5, 30));
  CHECK(f.settle() == 0);
  CHECK(f.num_checks == 0);
}

TEST_CASE(
    "a fusion is refused while the graph is uncertain, and asked again when a loop closure comes") {
  Fixture f;
  const GraphRevision open = row_of_nodes(100);  // 0.1 m a step: 0.3 m and more over nine
  f.map.set_graph(&open);
  f.map.add(f.finished(0, 0, 3));
  f.map.add(f.finished(1, 9, 3));
  CHECK(f.settle() == 0);
  REQUIRE(f.last_judgement.sigma_m.has_value());
  CHECK((*f.last_judgement.sigma_m)[2] > 0.2);
  CHECK(f.settle() == 0);
  CHECK(f.num_judged == 1);
  const GraphRevision closed = with_loop(row_of_nodes(100), 0, 9, 1e6);
  f.map.set_graph(&closed);
  CHECK(f.settle() == 1);
  CHECK(f.num_checks == 1);
}

TEST_CASE(
    "without a loop closure between them the graph must know two submaps to a limit of its own") {
  Config config;
  config.fusion.max_sigma_unlooped_m = 0.065;
  Fixture f(config);
  const GraphRevision graph =
      row_of_nodes(2000);  // 0.022 m a step: 0.067 m and more over nine, below 0.2 m
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 0, 3));
  f.map.add(f.finished(1, 9, 3));
  CHECK(f.settle() == 0);
  CHECK(f.last_judgement.limit_m == doctest::Approx(f.config.fusion.max_sigma_unlooped_m));
}

TEST_CASE(
    "a graph without edges tells no uncertainty: the configuration says whether overlap alone is "
    "enough") {
  for (const bool fuse_without_covariance : {false, true}) {
    Config config;
    config.fusion.fuse_without_covariance = fuse_without_covariance;
    Fixture f(config);
    GraphRevision graph = row_of_nodes(1e6);
    graph.graph.edges.clear();
    f.map.set_graph(&graph);
    f.map.add(f.finished(0, 0, 3));
    f.map.add(f.finished(1, 9, 3));
    CHECK(f.settle() == (fuse_without_covariance ? 1 : 0));
    CHECK(f.num_judged == 1);
    CHECK(f.last_judgement.is_uncertainty_unavailable);
    CHECK_FALSE(f.last_judgement.sigma_m.has_value());
  }
}

TEST_CASE("without a graph nothing is fused") {
  Fixture f;
  f.map.add(f.finished(0, kNoNode, 3));
  f.map.add(f.finished(1, kNoNode, 3));
  CHECK(f.settle() == 0);
}

TEST_CASE("a submap that was finished before the first graph owns the node it is bound to") {
  Fixture f;
  f.map.add(f.finished(0, kNoNode, 3));
  CHECK(f.map.owner(0) == kNoSubmap);
  const GraphRevision graph = row_of_nodes(1e6);
  CHECK(f.map.set_graph(&graph) == 0);
  CHECK(f.map.submaps()[0]->root == 0);
  CHECK(f.map.owner(0) == 0);
}

TEST_CASE("moving a root moves its submap and nothing inside it") {
  Fixture f;
  GraphRevision graph = row_of_nodes(1e6);
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 5, 3));
  GraphRevision moved = graph;
  moved.graph.nodes[5].T_M_N.translation().y() += 0.7;
  CHECK(f.map.set_graph(&moved) == 0);
  CHECK(f.map.submaps()[0]->T_M_S.translation().y() == doctest::Approx(0.7));
  CHECK(f.map.submaps()[0]->volume.at(f.store, {24, 0, 0}) == 30);
}

TEST_CASE("a graph that has lost a root leaves its submap where it was") {
  Fixture f;
  const GraphRevision graph = row_of_nodes(1e6);
  f.map.set_graph(&graph);
  f.map.add(f.finished(0, 5, 3));
  GraphRevision shrunk;
  CHECK(f.map.set_graph(&shrunk) == 1);
  CHECK(f.map.submaps().size() == 1);
}

/// A row of rooms, four blocks wide each, with walls across the lane that the sensor takes. A submap sees its own room
/// and, over the walls, the neighbours'.
struct RowOfRooms : Fixture {
  static constexpr int kRoomBlocks = 4;
  /// A submap whose sensor walked through one room.
  Submap* seen_from(SubmapId id, NodeId root, int room) {
    Submap* submap = finished(id, root, kRoomBlocks * room);
    submap->path.clear();
    for (int k = 0; k < kRoomBlocks; ++k) {
      submap->path.add({(static_cast<float>(kRoomBlocks * room + k) + 0.5f) * 0.52f, 0.4f, 0.1f});
    }
    for (int x = kRoomBlocks * (room - 1); x < kRoomBlocks * (room + 2); ++x) {
      add_wall(*submap, x);
      if (x % kRoomBlocks == 0) close_lane(*submap, x);
    }
    return submap;
  }
  void close_lane(Submap& submap, int x_blocks) {
    Chunk* chunk = nullptr;
    std::uint32_t* place = submap.volume.make_place(map.pools(), {x_blocks, 0, 0}, &chunk);
    Block* block = submap.volume.make_block(map.pools(), *chunk, *place);
    for (int i = 0; i < kBlockVoxels; i += kBlockEdge) block->voxels[i] = 30;
  }
  /// Pairs of submaps with an overlap above 0.7, between which the graph would allow a fusion.
  int num_pairs_left() {
    int num_left = 0;
    const auto all = map.submaps();
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = a + 1; b < all.size(); ++b) {
        const VoxelOverlap overlap =
            voxel_overlap(store, all[a]->volume, all[b]->volume,
                          all[b]->T_M_S.inverse() * all[a]->T_M_S, config.voxel.voxel_size_m);
        if (std::max(overlap.ratio_a(), overlap.ratio_b()) <= 0.7) continue;
        num_left +=
            map.judge({all[a]->id, all[b]->id, map.joined_by_loop(all[a]->id, all[b]->id), {}})
                .is_accepted;
      }
    }
    return num_left;
  }
};

TEST_CASE("rooms that see into each other stay submaps of their own, and each place is held once") {
  RowOfRooms f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  for (int room = 0; room < 4; ++room) f.map.add(f.seen_from(room, 2 * room, room));
  CHECK(f.settle() == 0);
  CHECK(f.map.share_places() > 0);
  CHECK(f.map.submaps().size() == 4);
  CHECK(f.num_pairs_left() == 0);
  std::size_t num_blocks = 0;
  for (const Submap* submap : f.map.submaps()) num_blocks += submap->volume.num_blocks();
  CHECK(num_blocks == 6 * RowOfRooms::kRoomBlocks * 16);
  CHECK(f.map.share_places() == 0);
}

TEST_CASE("two paths on either side of a wall are two places, however much both have seen") {
  Fixture f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  Submap* beyond = f.finished(1, 8, 3);
  beyond->path.clear();
  beyond->path.add({3.5f * 0.52f, 0.52f + 0.4f, 0.1f});
  f.map.add(f.finished(0, 0, 3));
  f.map.add(beyond);
  CHECK(f.settle() == 0);
  CHECK(f.map.submaps().size() == 2);
}

TEST_CASE("a room is shared with its neighbours once it is whole") {
  RowOfRooms f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  f.map.add(f.seen_from(0, 0, 0));
  Submap* part = f.seen_from(1, 2, 1);
  part->is_continued = true;
  f.map.add(part);
  CHECK(f.settle() == 0);
  CHECK(f.map.share_places() == 0);
  Submap* rest = f.seen_from(2, 2, 1);
  rest->continues = 1;
  f.map.add(rest);
  CHECK(f.settle() == 1);
  CHECK(f.map.share_places() > 0);
}

TEST_CASE("what is left of a submap that left nearly all to others joins the one that has its place") {
  for (const SubmapId remnant_id : {0, 1}) {
    CAPTURE(remnant_id);
    Fixture f;
    const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
    f.map.set_graph(&graph);
    const SubmapId keeper_id = 1 - remnant_id;
    Submap* remnant = f.finished(remnant_id, 0, 3);
    Submap* keeper = f.finished(keeper_id, 9, 3);
    f.walk_on(*remnant, *keeper);
    f.add_wall(*remnant, 14);
    f.map.add(remnant);
    f.map.add(keeper);
    CHECK_FALSE(f.map.find_remnant());
    CHECK(f.map.share_places() == 11 * 16);
    REQUIRE(remnant->volume.num_blocks() == 16);
    const std::size_t path_of_keeper = keeper->path.points().size();
    const auto found = f.map.find_remnant();
    REQUIRE(found);
    CHECK(found->a == keeper_id);
    CHECK(found->b == remnant_id);
    const Pose T_M_keeper = keeper->T_M_S;
    CHECK(f.map.absorb(*found) == remnant);
    CHECK_FALSE(f.map.find_remnant());
    REQUIRE(f.map.submaps().size() == 1);
    REQUIRE(f.map.find(keeper_id) == keeper);
    CHECK(keeper->id == keeper_id);
    CHECK(keeper->root == 9);
    CHECK(keeper->T_M_S.isApprox(T_M_keeper));
    CHECK(keeper->path.points().size() == path_of_keeper);
    CHECK(keeper->merged_from == std::vector<SubmapId>{remnant_id});
    CHECK(keeper->volume.num_blocks() == 12 * 16);
    CHECK(f.map.survivor(remnant_id) == keeper_id);
    CHECK(remnant->volume.num_blocks() == 0);
    CHECK(f.settle() == 0);
    // Where the heir lies is for its own nodes to say.
    GraphRevision moved = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
    moved.graph.nodes[0].T_M_N.translation().y() += 0.5;
    f.map.set_graph(&moved);
    CHECK(keeper->T_M_S.isApprox(T_M_keeper));
  }
}

TEST_CASE("a submap that continues another and was refused is done with, whatever is left of it") {
  Fixture f;
  // Too doubtful a graph for a fusion; then one that is certain, without a new loop closure to ask again.
  const GraphRevision doubtful = with_loop(row_of_nodes(10), 0, 9, 1);
  f.map.set_graph(&doubtful);
  Submap* remnant = f.finished(0, 0, 3);
  Submap* keeper = f.finished(1, 9, 3);
  remnant->is_continued = true;
  keeper->continues = 0;
  f.walk_on(*remnant, *keeper);
  f.map.add(remnant);
  f.map.add(keeper);
  CHECK(f.settle() == 0);
  GraphRevision certain = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  certain.revision = 2;
  certain.new_loops.clear();
  f.map.set_graph(&certain);
  CHECK(f.settle() == 0);
  CHECK(f.map.share_places() > 0);
  const auto found = f.map.find_remnant();
  REQUIRE(found);
  CHECK(f.map.absorb(*found) == remnant);
  CHECK(f.map.submaps().size() == 1);
  CHECK_FALSE(f.map.find_remnant());
}

TEST_CASE("what a submap still knows of its own keeps it apart, and so does a doubtful graph") {
  for (const int num_own : {1, 2}) {
    for (const double information : {1.0, 1e6}) {
      CAPTURE(num_own);
      Fixture f;
      const GraphRevision graph = with_loop(row_of_nodes(10 * information), 0, 9, information);
      f.map.set_graph(&graph);
      Submap* left = f.finished(1, 9, 3);
      Submap* keeper = f.finished(0, 0, 3);
      f.walk_on(*left, *keeper);
      for (int x = 14; x < 14 + num_own; ++x) f.add_wall(*left, x);
      f.map.add(keeper);
      f.map.add(left);
      CHECK(f.map.share_places() > 0);
      CHECK(f.map.find_remnant().has_value() == (num_own == 1 && information > 1));
    }
  }
}

TEST_CASE(
    "rooms visited again come back to one submap each, and no pair is left that should have been "
    "fused") {
  RowOfRooms f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  for (int visit = 0; visit < 8; ++visit) {
    f.map.add(f.seen_from(visit, visit, visit % 4));
    CHECK(f.settle() == (visit < 4 ? 0 : 1));
    (void)f.map.share_places();
    CHECK(f.num_pairs_left() == 0);
  }
  CHECK(f.map.submaps().size() == 4);
  for (int visit = 4; visit < 8; ++visit) CHECK(f.map.survivor(visit) == visit - 4);
}

TEST_CASE("a fusion lays a submap's blocks on the map's again, by whole voxels, and moves nothing in the map") {
  Fixture f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&graph);
  Submap* into = f.finished(0, 0, 3);
  f.map.add(into);
  // The graph moves it by two voxels and a bit along x, and by three along y.
  GraphRevision moved = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  for (GraphNode& node : moved.graph.nodes) node.T_M_N.translation() += Eigen::Vector3d(0.15, -0.195, 0.02);
  f.map.set_graph(&moved);
  Submap* from = f.finished(1, 9, 3);
  f.map.add(from);
  const Pose T_b_a = from->T_M_S.inverse() * into->T_M_S;
  const Eigen::Vector3d wall_M = into->T_M_S * Eigen::Vector3d(3.5 * 0.52, 0.52 * 2 + 0.1, 0.5);
  const Eigen::Vector3d trail_M = into->T_M_S * into->path.points()[0].cast<double>();
  const auto at = [&](const Eigen::Vector3d& p_M) {
    const Eigen::Vector3d p_vox = into->T_M_S.inverse() * p_M / f.config.voxel.voxel_size_m;
    return into->volume.at(f.store, p_vox.array().floor().matrix().cast<int>());
  };
  const LogOdds before = at(wall_M);
  CHECK(before > 0);
  REQUIRE(f.map.fuse({0, 1, true, {}}, T_b_a) == from);
  const Eigen::Vector3d off = into->T_M_S.translation() / 0.52;
  CHECK((off - Eigen::Vector3d(off.array().round())).cwiseAbs().maxCoeff() * 0.52 < 1.5 * 0.065);
  CHECK(at(wall_M) > 0);
  CHECK((into->T_M_S * into->path.points()[0].cast<double>() - trail_M).norm() < 1e-5);
  // Its nodes still say where it is.
  const Pose T_M_S = into->T_M_S;
  f.map.set_graph(&moved);
  CHECK(into->T_M_S.isApprox(T_M_S, 1e-9));
  CHECK(f.map.pools().blocks.num_free() == f.store.num_blocks() - into->volume.num_blocks());
}

/// Two rooms that have shared, and a submap that leads through both, and on where nobody was, half a metre aside.
struct TrailThroughRooms : RowOfRooms {
  TrailThroughRooms() {
    map.set_graph(&graph);
    room = seen_from(0, 0, 0);
    next_room = seen_from(1, 2, 1);
    map.add(room);
    map.add(next_room);
    CHECK(settle() == 0);
    CHECK(map.share_places() > 0);
    across = seen_from(2, 0, 0);
    for (int x = 2 * kRoomBlocks; x < 4 * kRoomBlocks; ++x) add_wall(*across, x);
    across->path.clear();
    for (float x = 0.1f; x < 3.5f * kRoomM; x += 0.3f) across->path.add({x, 0.9f, 0.1f});
    map.add(across);
  }
  /// Of the first room's trail, the points between two places.
  [[nodiscard]] int num_between(float low_m, float high_m) const {
    const auto points = room->path.points();
    return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3f& p) {
      return p.x() > low_m && p.x() < high_m;
    }));
  }
  static constexpr float kRoomM = kRoomBlocks * 0.52f;
  const GraphRevision graph = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  Submap* room = nullptr;
  Submap* next_room = nullptr;
  Submap* across = nullptr;
};

TEST_CASE("of a trail through two rooms each gets no more than its own part, and both stay rooms of their own") {
  TrailThroughRooms f;
  REQUIRE(f.map.fuse({0, 2, true, {}}, Pose::Identity()) == f.across);
  CHECK(f.num_between(0, f.kRoomM) > RowOfRooms::kRoomBlocks);
  CHECK(f.num_between(f.kRoomM + 0.6f, 2 * f.kRoomM) == 0);
  CHECK(f.num_between(2 * f.kRoomM + 2, 4 * f.kRoomM) > 0);
  CHECK(f.settle() == 0);
  CHECK(f.map.share_places() > 0);
  CHECK(f.map.submaps().size() == 2);
  const VoxelCoord in_next_room(6 * kBlockEdge, 6, 1);
  CHECK(f.next_room->volume.at(f.store, in_next_room) == -30);
  CHECK(f.room->volume.at(f.store, in_next_room) == kUnknownLogOdds);
}

TEST_CASE("a neighbour that the graph is no longer certain of keeps no part of a trail") {
  TrailThroughRooms f;
  const GraphRevision doubtful = with_loop(row_of_nodes(10), 0, 9, 1);
  f.map.set_graph(&doubtful);
  REQUIRE(f.map.fuse({0, 2, true, {}}, Pose::Identity()) == f.across);
  CHECK(f.num_between(f.kRoomM + 0.6f, 2 * f.kRoomM) > 2);
}

TEST_CASE("across a wrong loop closure that admits its doubt nothing is fused or shared") {
  RowOfRooms f;
  // The chain alone knows the two to 0.9 m; the loop closure, to a metre.
  const GraphRevision graph = with_loop(row_of_nodes(10), 0, 9, 1);
  f.map.set_graph(&graph);
  f.map.add(f.seen_from(0, 0, 0));
  f.map.add(f.seen_from(1, 9, 0));
  CHECK(f.settle() == 0);
  CHECK(f.num_judged == 1);
  CHECK(f.map.share_places() == 0);
  CHECK(f.map.submaps().size() == 2);
  // Once the graph knows better, both are asked again.
  const GraphRevision better = with_loop(row_of_nodes(1e6), 0, 9, 1e6);
  f.map.set_graph(&better);
  CHECK(f.settle() == 1);
}

TEST_CASE(
    "neighbours of which the graph is in doubt drop their copies, once, and fill nothing in") {
  RowOfRooms f;
  GraphRevision graph = with_loop(row_of_nodes(10), 0, 9, 1);
  graph.revision = 1;
  f.map.set_graph(&graph);
  Submap* first = f.seen_from(0, 0, 0);
  Submap* second = f.seen_from(1, 9, 1);
  const std::size_t num_blocks = first->volume.num_blocks() + second->volume.num_blocks();
  f.map.add(first);
  f.map.add(second);
  CHECK(f.settle() == 0);
  // Both know two rooms of the four.
  const std::size_t num_copies = 2 * RowOfRooms::kRoomBlocks * 16;
  CHECK(f.map.share_places() == num_copies);
  CHECK(first->volume.num_blocks() + second->volume.num_blocks() == num_blocks - num_copies);
  CHECK(f.map.share_places() == 0);
  GraphRevision next = with_loop(row_of_nodes(10), 0, 9, 1);
  next.revision = 2;
  f.map.set_graph(&next);
  CHECK(f.map.share_places() == 0);
  CHECK(f.map.submaps().size() == 2);
}

}  // namespace
}  // namespace cloister
