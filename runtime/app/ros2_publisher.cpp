#include "runtime/app/ros2_publisher.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "firmware_interface/map/map_contents.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/occupied_points.hpp"
#include "mapping/overlap/voxel_overlap.hpp"
#include "runtime/app/outputs.hpp"

namespace cloister {
namespace {

// 6 MB: some milliseconds to write down.
constexpr std::uint64_t kMaxPoints = 300'000;
constexpr double kNearlyFull = 0.9;

std::string text_of(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

void Ros2Publisher::publish(const Diagnostics& diagnostics) {
  ros2::Diagnostic status;
  status.name = "cloister: mapper";
  status.hardware_id = "cloister";
  double drops = 0, scans_per_s = 0, used = 0, size = 1;
  for (const auto& [name, value] : diagnostics.values) {
    status.values.emplace_back(name, text_of(value));
    if (name.starts_with("drops.")) drops += value;
    if (name == "scans_per_s") scans_per_s = value;
    if (name == "pool_blocks_used") used = value;
    if (name == "pool_blocks") size = value;
  }
  status.level = ros2::Diagnostic::Level::kOk;
  status.message = "mapping";
  if (scans_per_s <= 0) {
    status.level = ros2::Diagnostic::Level::kStale;
    status.message = "no scans";
  }
  if (used > kNearlyFull * size) {
    status.level = ros2::Diagnostic::Level::kWarning;
    status.message = "memory is nearly full";
  }
  if (drops > num_drops_) {
    status.level = ros2::Diagnostic::Level::kWarning;
    status.message = "input was dropped";
  }
  num_drops_ = drops;
  topics_.publish(diagnostics.stamp, status);
}

const Submap* Ros2Publisher::find(SubmapId id) const {
  for (const Submap* submap : pipeline_.present_submaps()) {
    if (submap->id == id) return submap;
  }
  return nullptr;
}

void Ros2Publisher::publish(const SubmapList& list, const PoseGraph& graph) {
  publish_markers(list, graph);
  publish_occupied(list);
}

void Ros2Publisher::publish_markers(const SubmapList& list, const PoseGraph& graph) {
  const double voxel_m = pipeline_.record().config.voxel.voxel_size_m;
  std::vector<ros2::SubmapMarker> submaps;
  for (const SubmapState& state : list.submaps) {
    const Submap* submap = find(state.id);
    if (submap == nullptr) continue;
    submaps.push_back({state.id, state.T_M_S,
                       known_bounds(pipeline_.store(), submap->volume, voxel_m),
                       (state.T_M_S * submap->T_root_S.inverse()).translation(), state.is_active});
  }
  std::vector<ros2::LoopMarker> loops;
  for (const GraphEdge& edge : graph.edges) {
    if (!edge.is_loop_closure()) continue;
    const auto place = [&](NodeId id) -> Eigen::Vector3d {
      return graph.nodes[static_cast<std::size_t>(graph.find(id))].T_M_N.translation();
    };
    loops.push_back({place(edge.from), place(edge.to)});
  }
  topics_.publish_submaps({list.stamp, options_.map_frame}, submaps, loops);
}

void Ros2Publisher::publish_occupied(const SubmapList& list) {
  const ros2::MapTopics::Readers readers = topics_.readers_of_occupied();
  if (readers.is_new) shown_.clear();
  if (!readers.is_any) return;
  std::vector<const SubmapState*> changed;
  for (const SubmapState& state : list.submaps) {
    if (state.is_active || shown_[state.id].version != state.version) changed.push_back(&state);
  }
  std::stable_sort(changed.begin(), changed.end(), [&](const SubmapState* a, const SubmapState* b) {
    if (a->is_active != b->is_active) return a->is_active;
    return shown_[a->id].turn < shown_[b->id].turn;
  });
  ++turn_;
  std::vector<const Submap*> submaps;
  std::uint64_t num_points = 0;
  for (const SubmapState* state : changed) {
    const Submap* submap = find(state->id);
    if (submap == nullptr) continue;
    num_points += count_occupied(view_of(pipeline_, std::span(&submap, 1)));
    if (num_points > kMaxPoints && !submaps.empty()) break;
    submaps.push_back(submap);
    shown_[state->id] = {state->version, turn_};
  }
  if (num_points == 0) return;
  topics_.publish_occupied({list.stamp, options_.map_frame}, view_of(pipeline_, submaps));
}

void Ros2Publisher::publish_transform(const LiveFeed& feed) {
  const auto& timeline = pipeline_.record().timeline;
  if (!options_.transform || timeline.empty() || timeline.back().stamp == transform_stamp_) return;
  const auto T_M_O = feed.T_M_O();
  if (!T_M_O) return;
  transform_stamp_ = timeline.back().stamp;
  topics_.publish_transform({transform_stamp_, options_.map_frame}, options_.odometry_frame,
                            *T_M_O);
}

void Ros2Publisher::serve_octomap() {
  is_octomap_asked_ |= topics_.take_octomap_request();
  if (octomap_.valid()) {
    if (octomap_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    if (const auto data = octomap_.get()) {
      topics_.publish_octomap({octomap_stamp_, options_.map_frame},
                              pipeline_.record().config.voxel.voxel_size_m, *data);
    }
  }
  const auto& timeline = pipeline_.record().timeline;
  if (!is_octomap_asked_ || timeline.empty() || !pipeline_.is_idle()) return;
  is_octomap_asked_ = false;
  pipeline_.drain();
  const Eigen::Vector3d here_M = timeline.back().T_M_L.translation();
  std::vector<const Submap*> local;
  for (const Submap* submap : pipeline_.present_submaps()) {
    const auto bounds = known_bounds(pipeline_.store(), submap->volume,
                                     pipeline_.record().config.voxel.voxel_size_m);
    if (bounds.isEmpty()) continue;
    const Eigen::Vector3d here_S = submap->T_M_S.inverse() * here_M;
    if (bounds.exteriorDistance(here_S) <= options_.octomap_radius_m) local.push_back(submap);
  }
  auto map = std::make_unique<LoadedMap>(copy_map(view_of(pipeline_, local)));
  octomap_stamp_ = timeline.back().stamp;
  octomap_ = std::async(std::launch::async,
                        [map = std::move(map)] { return octomap_data(map->view(), false); });
}

}  // namespace cloister
