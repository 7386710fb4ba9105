#include "runtime/app/map_service.hpp"

#include <utility>
#include <vector>

#include "runtime/cpu_clock.hpp"

namespace cloister {
namespace {

constexpr std::chrono::milliseconds kPatience{250};
constexpr std::size_t kMaxWaitingHulls = 32;
// 0.5 MB an answer.
constexpr std::size_t kMaxBlocks = 1024;
// Volumes are looked through anew this often at most.
constexpr std::chrono::milliseconds kUpdatePeriod{100};

}  // namespace

std::optional<ResetRequest> MapService::take_reset() {
  std::optional<ResetRequest> last;
  for (ResetRequest request; requests_.take(request);) last = request;
  return last;
}

void MapService::serve(HostTime now, const LiveFeed& feed) {
  for (HullRequest request; requests_.take(request);) {
    if (hulls_.size() == kMaxWaitingHulls) {
      HullReply reply;
      reply.id = request.id;
      reply.message = "too many questions wait for an answer; ask again";
      requests_.publish(reply);
      continue;
    }
    hulls_.push_back({std::move(request), now});
  }
  if (!blocks_) {
    if (BlocksRequest request; requests_.take(request)) blocks_ = request;
  }
  if (hulls_.empty() && !blocks_) return;
  const bool is_urgent = !hulls_.empty() && now - hulls_.front().arrived >= kPatience;
  if (!is_urgent && !pipeline_.is_idle()) return;
  pipeline_.drain();
  if (!hulls_.empty()) answer_hulls(feed);
  if (blocks_) answer_blocks(*std::exchange(blocks_, std::nullopt), now);
}

void MapService::answer_hulls(const LiveFeed& feed) {
  const MissionRecord& record = pipeline_.record();
  const VoxelConfig& voxel = record.config.voxel;
  const std::vector<const Submap*> submaps = pipeline_.present_submaps();
  HullQuery query(pipeline_.store(), voxel.voxel_size_m, log_odds_steps(voxel.log_odds_min),
                  log_odds_steps(voxel.log_odds_max), submaps);
  for (; !hulls_.empty(); hulls_.pop_front()) {
    const HullRequest& request = hulls_.front().request;
    HullReply reply;
    reply.id = request.id;
    if (!record.timeline.empty()) reply.stamp = record.timeline.back().stamp;
    reply.graph_revision = feed.graph_revision();
    const StopWatch watch;
    std::vector<Eigen::Vector3d> corners_M;
    for (const Eigen::Vector3d& corner_H : request.corners_H)
      corners_M.push_back(request.T_M_H * corner_H);
    if (const auto answer = query.at(corners_M)) {
      reply.is_answered = true;
      reply.answer = *answer;
    } else {
      reply.message = "a hull has 1 to 64 finite corners and bounds of up to 75,000 voxels";
    }
    reply.cpu_ms = 1e-6 * static_cast<double>(watch.cpu_ns());
    requests_.publish(reply);
  }
}

void MapService::answer_blocks(const BlocksRequest& request, HostTime now) {
  BlocksReply reply;
  reply.id = request.id;
  reply.submap = request.submap;
  reply.voxel_size_m = pipeline_.record().config.voxel.voxel_size_m;
  for (const Submap* submap : pipeline_.present_submaps()) {
    if (submap->id != request.submap) continue;
    Tracked& tracked =
        tracked_.try_emplace(submap->id, BlockChanges(first_change_), HostTime()).first->second;
    if (now - tracked.updated >= kUpdatePeriod) {
      tracked.updated = now;
      tracked.changes.update(pipeline_.store(), submap->volume);
    }
    reply.is_there = true;
    reply.T_M_S = submap->T_M_S;
    reply.delta =
        tracked.changes.since(pipeline_.store(), submap->volume, request.since, kMaxBlocks);
  }
  if (!reply.is_there) tracked_.erase(request.submap);
  requests_.publish(reply);
}

}  // namespace cloister
