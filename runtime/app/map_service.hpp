#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "firmware_interface/dds/map_requests.hpp"
#include "firmware_interface/mission/live_feed.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// Answers questions about the map as it stands between two scans.
///
/// All submaps can be read while nothing is under way: no scan, comparison or fusion. That moment comes after almost
/// every scan; where it has not come 250 ms after a question did, the pipeline is run dry for it. So the threads that
/// map never wait for a question, share no lock with it, and nothing changes while it is answered; what arrives
/// meanwhile waits where it always waits.
///
/// Threads: the reader's, which the pipeline knows.
class MapService {
 public:
  using HostTime = std::chrono::steady_clock::time_point;

  /// @param first_change  see BlockChanges
  MapService(MapRequests& requests, Pipeline& pipeline, std::uint64_t first_change)
      : requests_(requests), pipeline_(pipeline), first_change_(first_change) {}

  /// Takes questions in, and answers if it is the time to.
  void serve(HostTime now, const LiveFeed& feed);
  /// The request to begin anew, once; whoever owns the pipeline does so and answers.
  [[nodiscard]] std::optional<ResetRequest> take_reset();

 private:
  struct Waiting {
    HullRequest request;
    HostTime arrived;
  };
  struct Tracked {
    BlockChanges changes;
    HostTime updated;
  };

  void answer_hulls(const LiveFeed& feed);
  void answer_blocks(const BlocksRequest& request, HostTime now);

  MapRequests& requests_;
  Pipeline& pipeline_;
  std::uint64_t first_change_;
  std::deque<Waiting> hulls_;
  std::optional<BlocksRequest> blocks_;
  std::map<SubmapId, Tracked> tracked_;
};

}  // namespace cloister
