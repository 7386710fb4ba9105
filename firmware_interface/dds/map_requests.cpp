#include "firmware_interface/dds/map_requests.hpp"

#include <cloister_native.h>

#include <algorithm>
#include <iterator>

#include <dds/dds.h>

#include "firmware_interface/dds/topic_ends.hpp"
#include "firmware_interface/dds/wire_types.hpp"

namespace cloister {
namespace {

static_assert(HullQuery::kMaxCorners == cloister_wire_MAX_CORNERS);

bool hand_over(const DdsEntity& writer, const void* message) {
  return dds_write(writer.handle(), message) == DDS_RETCODE_OK;
}

/// Voxels travel as bytes.
std::vector<LogOdds> voxels_of(const cloister_wire_BlockState& block) {
  std::vector<LogOdds> voxels;
  if (block.voxels._length != kBlockVoxels) return voxels;
  for (std::uint32_t i = 0; i < block.voxels._length; ++i)
    voxels.push_back(static_cast<LogOdds>(block.voxels._buffer[i]));
  return voxels;
}

}  // namespace

struct MapRequests::Ends {
  DdsEntity hull, blocks, reset;
  DdsEntity hull_reply, blocks_reply, reset_reply;
};

MapRequests::MapRequests(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
MapRequests::MapRequests(MapRequests&&) noexcept = default;
MapRequests& MapRequests::operator=(MapRequests&&) noexcept = default;
MapRequests::~MapRequests() = default;

Result<MapRequests> MapRequests::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  ends->hull = make.reader(kHullTopic);
  ends->blocks = make.reader(kBlocksTopic);
  ends->reset = make.reader(kResetTopic);
  ends->hull_reply = make.writer(kHullReplyTopic);
  ends->blocks_reply = make.writer(kBlocksReplyTopic);
  ends->reset_reply = make.writer(kResetReplyTopic);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  return MapRequests(std::move(ends));
}

bool MapRequests::take(HullRequest& request) {
  cloister_wire_HullRequest message;
  if (!take_fixed(ends_->hull, message)) return false;
  request = {message.id, from_wire(message.pose_T_M_H), {}};
  // One too many shows that there were too many.
  const auto num_corners = std::min<std::size_t>(message.num_corners, HullQuery::kMaxCorners + 1);
  for (std::size_t i = 0; i < num_corners; ++i) {
    const double* corner = message.corners_H + 3 * std::min(i, HullQuery::kMaxCorners - 1);
    request.corners_H.emplace_back(corner[0], corner[1], corner[2]);
  }
  return true;
}

bool MapRequests::take(BlocksRequest& request) {
  cloister_wire_BlocksRequest message;
  if (!take_fixed(ends_->blocks, message)) return false;
  request = {message.id, message.submap, message.since};
  return true;
}

bool MapRequests::take(ResetRequest& request) {
  cloister_wire_ResetRequest message;
  if (!take_fixed(ends_->reset, message)) return false;
  request.id = message.id;
  return true;
}

void MapRequests::publish(const HullReply& reply) {
  cloister_wire_HullReply message{};
  message.id = reply.id;
  message.is_answered = reply.is_answered;
  message.message = const_cast<char*>(reply.message.c_str());
  message.state = static_cast<std::uint8_t>(reply.answer.state);
  message.submap = reply.answer.submap;
  std::copy_n(reply.answer.where_M.data(), 3, message.where_M);
  message.stamp_ns = reply.stamp.ns;
  message.graph_revision = reply.graph_revision;
  message.cpu_ms = reply.cpu_ms;
  (void)hand_over(ends_->hull_reply, &message);
}

void MapRequests::publish(const BlocksReply& reply) {
  std::vector<cloister_wire_BlockState> blocks;
  for (const BlockState& block : reply.delta.blocks) {
    cloister_wire_BlockState& state = blocks.emplace_back();
    state = {block.coord.x(),
             block.coord.y(),
             block.coord.z(),
             block.known,
             static_cast<std::uint8_t>(block.coarse),
             {}};
    state.voxels._length = state.voxels._maximum = static_cast<std::uint32_t>(block.voxels.size());
    // Only read by dds_write.
    state.voxels._buffer =
        reinterpret_cast<std::uint8_t*>(const_cast<LogOdds*>(block.voxels.data()));
  }
  cloister_wire_BlocksReply message{};
  message.id = reply.id;
  message.submap = reply.submap;
  message.is_there = reply.is_there;
  to_wire(reply.T_M_S, message.pose_T_M_S);
  message.voxel_size_m = reply.voxel_size_m;
  message.since = reply.delta.since;
  message.up_to = reply.delta.up_to;
  message.is_last = reply.delta.is_last;
  message.blocks._length = message.blocks._maximum = static_cast<std::uint32_t>(blocks.size());
  message.blocks._buffer = blocks.data();
  (void)hand_over(ends_->blocks_reply, &message);
}

void MapRequests::publish(const ResetReply& reply) {
  const cloister_wire_ResetReply message{reply.id};
  (void)hand_over(ends_->reset_reply, &message);
}

struct MapClient::Ends {
  DdsEntity hull, blocks, reset;
  DdsEntity hull_reply, blocks_reply, reset_reply;
};

MapClient::MapClient(std::unique_ptr<Ends> ends) : ends_(std::move(ends)) {}
MapClient::MapClient(MapClient&&) noexcept = default;
MapClient& MapClient::operator=(MapClient&&) noexcept = default;
MapClient::~MapClient() = default;

Result<MapClient> MapClient::open(const DdsLink& link) {
  auto ends = std::make_unique<Ends>();
  EndMaker make(link.participant());
  ends->hull = make.writer(kHullTopic);
  ends->blocks = make.writer(kBlocksTopic);
  ends->reset = make.writer(kResetTopic);
  ends->hull_reply = make.reader(kHullReplyTopic);
  ends->blocks_reply = make.reader(kBlocksReplyTopic);
  ends->reset_reply = make.reader(kResetReplyTopic);
  if (auto made = make.outcome(); !made) return tl::unexpected(made.error());
  return MapClient(std::move(ends));
}

bool MapClient::wait_for_mapper(std::chrono::milliseconds timeout) {
  return wait_for_readers({&ends_->hull, &ends_->blocks, &ends_->reset}, timeout);
}

bool MapClient::publish(const HullRequest& request) {
  cloister_wire_HullRequest message{};
  message.id = request.id;
  to_wire(request.T_M_H, message.pose_T_M_H);
  message.num_corners = static_cast<std::uint32_t>(request.corners_H.size());
  for (std::size_t i = 0; i < std::min(request.corners_H.size(), HullQuery::kMaxCorners); ++i)
    std::copy_n(request.corners_H[i].data(), 3, message.corners_H + 3 * i);
  return hand_over(ends_->hull, &message);
}

bool MapClient::publish(const BlocksRequest& request) {
  const cloister_wire_BlocksRequest message{request.id, request.submap, request.since};
  return hand_over(ends_->blocks, &message);
}

bool MapClient::publish(const ResetRequest& request) {
  const cloister_wire_ResetRequest message{request.id};
  return hand_over(ends_->reset, &message);
}

bool MapClient::take(HullReply& reply) {
  return take_loaned<cloister_wire_HullReply>(
      ends_->hull_reply, [&](const cloister_wire_HullReply& message) {
        reply.id = message.id;
        reply.is_answered = message.is_answered;
        reply.message = message.message;
        reply.answer = {static_cast<VoxelState>(message.state),
                        Eigen::Vector3d(message.where_M[0], message.where_M[1], message.where_M[2]),
                        message.submap};
        reply.stamp = SensorTime{message.stamp_ns};
        reply.graph_revision = message.graph_revision;
        reply.cpu_ms = message.cpu_ms;
      });
}

bool MapClient::take(BlocksReply& reply) {
  return take_loaned<cloister_wire_BlocksReply>(
      ends_->blocks_reply, [&](const cloister_wire_BlocksReply& message) {
        reply = {message.id,           message.submap,
                 message.is_there,     from_wire(message.pose_T_M_S),
                 message.voxel_size_m, {message.since, message.up_to, message.is_last, {}}};
        for (std::uint32_t i = 0; i < message.blocks._length; ++i) {
          const cloister_wire_BlockState& block = message.blocks._buffer[i];
          reply.delta.blocks.push_back({BlockCoord(block.x, block.y, block.z), block.known_octants,
                                        static_cast<LogOdds>(block.coarse), voxels_of(block)});
        }
      });
}

bool MapClient::take(ResetReply& reply) {
  cloister_wire_ResetReply message;
  if (!take_fixed(ends_->reset_reply, message)) return false;
  reply.id = message.id;
  return true;
}

}  // namespace cloister
