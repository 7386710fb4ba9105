#include "runtime/app/status_publisher.hpp"

#include <algorithm>
#include <vector>

#include "mapping/record/mission_record.hpp"

namespace cloister {
namespace {

constexpr std::chrono::seconds kPeriod{1};
// Latency is that of the last minute at 10 Hz.
constexpr std::ptrdiff_t kLatencyScans = 600;

}  // namespace

void StatusPublisher::publish_if_due(HostTime now, const LiveFeed& feed,
                                     const std::map<std::string, std::int64_t>& drops) {
  if (now - last_diagnostics_ >= kPeriod) publish_diagnostics(now, feed, drops);
  if (now - last_submaps_ >= kPeriod && pipeline_.is_idle()) {
    last_submaps_ = now;
    publish_submaps(feed);
  }
}

void StatusPublisher::publish_diagnostics(HostTime now, const LiveFeed& feed,
                                          const std::map<std::string, std::int64_t>& drops) {
  const MissionRecord& record = pipeline_.record();
  const std::vector<TimelineRow>& timeline = record.timeline;
  Diagnostics diagnostics;
  const auto add = [&](std::string name, auto value) {
    diagnostics.values.emplace_back(std::move(name), static_cast<double>(value));
  };
  const double seconds = std::chrono::duration<double>(now - last_diagnostics_).count();
  const bool has_rate = last_diagnostics_ != HostTime();
  const std::uint64_t odometry = feed.counters()[FeedCause::kOdometry];
  add("scans_per_s",
      has_rate ? static_cast<double>(record.scans_integrated - last_integrated_) / seconds : 0.0);
  add("odometry_per_s", has_rate ? static_cast<double>(odometry - last_odometry_) / seconds : 0.0);
  last_diagnostics_ = now;
  last_integrated_ = record.scans_integrated;
  last_odometry_ = odometry;

  std::vector<float> latency_ms;
  const auto num_recent = std::min<std::ptrdiff_t>(kLatencyScans, std::ssize(timeline));
  for (auto row = timeline.end() - num_recent; row != timeline.end(); ++row)
    latency_ms.push_back(row->latency_ms);
  add("latency_p99_ms", summarise(std::move(latency_ms)).p99);
  add("scans_received", feed.num_scans_read());
  add("scans_integrated", record.scans_integrated);
  add("scans_waiting_for_pose", feed.num_waiting_scans());
  const Pipeline::Fill fill = pipeline_.fill();
  add("queue_commands", fill.commands_waiting);
  add("pool_blocks_used", fill.blocks_used);
  add("pool_blocks", fill.num_blocks);
  add("pool_chunks_used", fill.chunks_used);
  add("pool_chunks", fill.num_chunks);
  add("submaps", timeline.empty() ? 0 : timeline.back().submaps);
  add("map_bytes", timeline.empty() ? 0 : timeline.back().map_bytes);
  add("graph_revision", feed.graph_revision());
  add("shared_memory", uses_shared_memory_ ? 1 : 0);
  for (const auto& [cause, count] : record.drops) add("drops." + cause, count);
  for (const auto& [cause, count] : drops) add("drops." + cause, count);
  if (!timeline.empty()) diagnostics.stamp = timeline.back().stamp;
  topics_.publish(diagnostics);
  if (ros2_ != nullptr) ros2_->publish(diagnostics);
}

void StatusPublisher::publish_submaps(const LiveFeed& feed) {
  pipeline_.drain();
  const MissionRecord& record = pipeline_.record();
  SubmapList list;
  if (!record.timeline.empty()) list.stamp = record.timeline.back().stamp;
  list.graph_revision = feed.graph_revision();
  for (const Submap* submap : pipeline_.present_submaps()) {
    SubmapState state;
    state.id = submap->id;
    state.is_active = submap == pipeline_.active_submap();
    state.root_node = submap->root;
    state.T_M_S = submap->T_M_S;
    state.blocks = submap->volume.num_blocks();
    state.bytes = submap->volume.bytes();
    // Scans go to the active submap only; others change by fusion, which adds an id, or by the graph.
    const std::int64_t num_scans = state.is_active ? record.scans_integrated : -1;
    Known& known = known_[submap->id];
    if (known.version == 0 || known.blocks != state.blocks || known.bytes != state.bytes ||
        known.num_merged != submap->merged_from.size() || known.num_scans != num_scans ||
        known.T_M_S.matrix() != state.T_M_S.matrix()) {
      known = {known.version + 1,          state.blocks, state.bytes,
               submap->merged_from.size(), num_scans,    state.T_M_S};
    }
    state.version = known.version;
    list.submaps.push_back(state);
  }
  std::sort(list.submaps.begin(), list.submaps.end(),
            [](const SubmapState& a, const SubmapState& b) { return a.id < b.id; });
  topics_.publish(list);
  if (ros2_ != nullptr) ros2_->publish(list, feed.graph());
}

}  // namespace cloister
