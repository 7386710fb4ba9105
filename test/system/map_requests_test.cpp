// Questions to a live mapper about its map, and beginning anew.
#include "firmware_interface/dds/map_requests.hpp"

#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "test/support/live_host.hpp"

namespace cloister {
namespace {

using namespace std::chrono_literals;

/// The answer to a question, asked once.
template <typename Reply, typename Request>
Reply ask(MapClient& client, const Request& request) {
  REQUIRE(client.publish(request));
  Reply reply;
  for (int i = 0; i < 6000; ++i) {
    if (client.take(reply) && reply.id == request.id) return reply;
    std::this_thread::sleep_for(10ms);
  }
  FAIL("no answer");
  return reply;
}

/// A cube of half a metre.
HullRequest cube_at(std::uint64_t id, double x_m, double y_m, double z_m) {
  HullRequest request;
  request.id = id;
  request.T_M_H.translation() = Eigen::Vector3d(x_m, y_m, z_m);
  for (int i = 0; i < 8; ++i) {
    request.corners_H.emplace_back((i & 1) != 0 ? 0.25 : -0.25, (i & 2) != 0 ? 0.25 : -0.25,
                                   (i & 4) != 0 ? 0.25 : -0.25);
  }
  return request;
}

TEST_CASE(
    "a planner is told what is free, occupied and unknown, blocks that changed come once, and a "
    "reset forgets them") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({kRoom});
  Robot robot;
  auto opened = MapClient::open(robot.link());
  REQUIRE(opened.has_value());
  MapClient client = std::move(*opened);
  REQUIRE(client.wait_for_mapper(60s));

  // Nothing is known of an empty map.
  auto hull = ask<HullReply>(client, cube_at(1, 1, 0, 0));
  CHECK(hull.is_answered);
  CHECK(hull.answer.state == VoxelState::kUnknown);
  auto blocks = ask<BlocksReply>(client, BlocksRequest{2, 0, 0});
  CHECK_FALSE(blocks.is_there);

  // A round room of 3 m.
  robot.odometry(0, 2000);
  for (std::int64_t stamp_ms = 300; stamp_ms <= 1200; stamp_ms += 100) robot.scan(stamp_ms);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 10; });
  hull = ask<HullReply>(client, cube_at(3, 1.5, 0, 0));
  CHECK(hull.answer.state == VoxelState::kFree);
  CHECK(hull.stamp.ns == 1200 * kMs);
  MESSAGE("CPU time of an answer in free space, ms: " << hull.cpu_ms);
  hull = ask<HullReply>(client, cube_at(4, 2.9, 0, 0));
  CHECK(hull.answer.state == VoxelState::kOccupied);
  CHECK(hull.answer.submap == 0);
  CHECK(hull.answer.where_M.norm() == doctest::Approx(3).epsilon(0.05));
  MESSAGE("CPU time of an answer at a wall, ms: " << hull.cpu_ms);
  hull = ask<HullReply>(client, cube_at(5, 10, 0, 0));
  CHECK(hull.answer.state == VoxelState::kUnknown);
  HullRequest bad = cube_at(6, 0, 0, 0);
  bad.corners_H.resize(HullQuery::kMaxCorners + 1);
  hull = ask<HullReply>(client, bad);
  CHECK_FALSE(hull.is_answered);
  CHECK(hull.message.find("1 to 64 finite corners") != std::string::npos);

  // Everything, then nothing, then what another scan has changed.
  std::uint64_t id = 100, since = 0;
  std::size_t num_blocks = 0;
  const auto fetch = [&] {
    num_blocks = 0;
    do {
      blocks = ask<BlocksReply>(client, BlocksRequest{++id, 0, since});
      REQUIRE(blocks.is_there);
      num_blocks += blocks.delta.blocks.size();
      since = blocks.delta.up_to;
    } while (!blocks.delta.is_last);
  };
  fetch();
  CHECK(num_blocks > 100);
  CHECK(blocks.voxel_size_m == doctest::Approx(0.065));
  const std::size_t num_all = num_blocks;
  fetch();
  CHECK(num_blocks == 0);
  robot.scan(1300);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 11; });
  std::this_thread::sleep_for(200ms);  // changes are looked for ten times a second
  fetch();
  CHECK(num_blocks <= num_all);

  REQUIRE(ask<ResetReply>(client, ResetRequest{200}).id == 200);
  hull = ask<HullReply>(client, cube_at(201, 1.5, 0, 0));
  CHECK(hull.answer.state == VoxelState::kUnknown);
  blocks = ask<BlocksReply>(client, BlocksRequest{202, 0, since});
  CHECK_FALSE(blocks.is_there);
  // It goes on mapping, with what comes from now on.
  robot.odometry(3000, 4000);
  robot.scan(3500);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  blocks = ask<BlocksReply>(client, BlocksRequest{203, 0, since});
  CHECK(blocks.is_there);
  CHECK(blocks.delta.since == 0);
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.summary()["counters"]["resets"] == 1);
  CHECK(host.summary()["scans"]["integrated"] == 1);
  CHECK(host.map_loads());
}

}  // namespace
}  // namespace cloister
