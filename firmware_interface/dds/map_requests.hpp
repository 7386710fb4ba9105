#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware_interface/dds/dds_link.hpp"
#include "firmware_interface/map/block_changes.hpp"
#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/overlap/hull_query.hpp"

/// Questions to the mapper and its answers (cloister_native.idl), as plain types. Reliable, over UDP, last 8 of each
/// kind kept; every answer repeats its question's id and comes on the topic of the same name with `_reply` behind.
///
/// | topic               | asks                                                                          |
/// |---------------------|-------------------------------------------------------------------------------|
/// | cloister/check_hull | does this convex hull at this pose touch anything occupied or unknown?        |
/// | cloister/get_blocks | which of a submap's blocks have changed since?                                |
/// | cloister/reset      | forget the map and begin anew                                                 |
namespace cloister {

struct HullRequest {
  std::uint64_t id = 0;
  Pose T_M_H = Pose::Identity();
  std::vector<Eigen::Vector3d> corners_H;  ///< up to HullQuery::kMaxCorners
};

struct HullReply {
  std::uint64_t id = 0;
  bool is_answered = false;
  std::string message;  ///< why not
  HullAnswer answer;
  // Which map that was.
  SensorTime stamp;  ///< of the newest scan in it
  std::uint64_t graph_revision = 0;
  double cpu_ms = 0;
};

struct BlocksRequest {
  std::uint64_t id = 0;
  SubmapId submap = kNoSubmap;
  std::uint64_t since = 0;  ///< `up_to` of the last answer about this submap; 0: everything
};

struct BlocksReply {
  std::uint64_t id = 0;
  SubmapId submap = kNoSubmap;
  bool is_there = false;  ///< false: there is no such submap, or no longer
  Pose T_M_S = Pose::Identity();
  double voxel_size_m = 0;
  BlockDelta delta;
};

struct ResetRequest {
  std::uint64_t id = 0;
};
struct ResetReply {
  std::uint64_t id = 0;
};

/// The mapper's ends. Threads: one at a time. Nothing waits, but for 100 ms when a client does not take its answer.
class MapRequests {
 public:
  [[nodiscard]] static Result<MapRequests> open(const DdsLink& link);
  MapRequests(MapRequests&&) noexcept;
  MapRequests& operator=(MapRequests&&) noexcept;
  ~MapRequests();

  // Each removes one question that has arrived and returns false when there is none.
  bool take(HullRequest& request);
  bool take(BlocksRequest& request);
  bool take(ResetRequest& request);

  void publish(const HullReply& reply);
  void publish(const BlocksReply& reply);
  void publish(const ResetReply& reply);

 private:
  struct Ends;
  explicit MapRequests(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

/// The ends of whoever asks.
class MapClient {
 public:
  [[nodiscard]] static Result<MapClient> open(const DdsLink& link);
  MapClient(MapClient&&) noexcept;
  MapClient& operator=(MapClient&&) noexcept;
  ~MapClient();

  /// Waits until somebody reads the questions. @return whether somebody does
  [[nodiscard]] bool wait_for_mapper(std::chrono::milliseconds timeout);

  // Each returns false when DDS did not take it.
  bool publish(const HullRequest& request);
  bool publish(const BlocksRequest& request);
  bool publish(const ResetRequest& request);

  bool take(HullReply& reply);
  bool take(BlocksReply& reply);
  bool take(ResetReply& reply);

 private:
  struct Ends;
  explicit MapClient(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

}  // namespace cloister
