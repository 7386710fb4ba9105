#include "mapping/submap/local_mapper.hpp"

#include <utility>

#include "mapping/scan/scan_motion.hpp"

namespace cloister {
namespace {

// What is left of the overlap where a gateway opens into a wider place. A door comes down to little less than the limit.
constexpr double kThresholdShare = 0.85;

}  // namespace

LocalMapper::LocalMapper(const Config& config, VoxelStore& store, ScanWorkers* workers)
    : config_(config),
      pools_(store),
      integrator_(config.voxel, workers),
      beams_(static_cast<std::size_t>(config.scan.max_points)),
      cloud_(config.spawn, static_cast<std::size_t>(config.memory.max_cloud_points)) {
  spare_slots_.reserve(static_cast<std::size_t>(config.memory.max_submaps));
}

void LocalMapper::set_graph(const GraphRevision* revision) {
  revision_ = revision;
  if (active_ != nullptr) apply_graph(*active_, *revision);
}

Submap* LocalMapper::close() {
  last_.is_valid = false;
  return std::exchange(active_, nullptr);
}

bool LocalMapper::place(const Scan& scan, ScanOutcome& outcome) {
  outcome = {};
  if (scan.poses.empty() || !is_finite(scan.poses.front().T_R_L)) {
    outcome.refusal = ScanRefusal::kNoPose;
    return false;
  }
  T_M_R_ = Pose::Identity();
  if (scan.node != kNoNode) {
    const GraphNode* node = revision_ != nullptr ? revision_->node(scan.node) : nullptr;
    if (node == nullptr) {
      outcome.refusal = ScanRefusal::kUnknownNode;
      return false;
    }
    T_M_R_ = node->T_M_N;
  }
  T_R_L_ = ScanMotion(scan.poses).T_R_L(scan.stamp);
  T_M_L_ = T_M_R_ * T_R_L_;
  if (!is_place(T_M_L_)) {
    outcome.refusal = ScanRefusal::kNoPose;
    return false;
  }
  outcome.T_M_L = T_M_L_;
  outcome.node = scan.node;
  if (active_ != nullptr) {
    outcome.returns_declined = beams_.assign(scan, active_->T_M_S.inverse() * T_M_R_, config_.voxel);
  }
  return true;
}

double LocalMapper::present_shift_m(const Scan& scan) const {
  if (!last_.is_valid) return 0;
  if (last_.T_O_L && scan.T_O_L) {
    const Pose T_S_L_expected = last_.T_S_L * last_.T_O_L->inverse() * *scan.T_O_L;
    return displacement_m(T_S_L_expected.inverse() * T_S_L());
  }
  const GraphNode* node = revision_ != nullptr ? revision_->node(last_.node) : nullptr;
  if (node == nullptr) return 0;
  return displacement_m(last_.T_S_L.inverse() * active_->T_M_S.inverse() * node->T_M_N * last_.T_R_L);
}

void LocalMapper::filter_cloud() { cloud_.filter(beams_, T_S_C_.inverse().cast<float>()); }

bool LocalMapper::check_spawn(const Scan& scan, ScanOutcome& outcome) {
  if (active_ == nullptr) return spawn(scan, SpawnReason::kFirst, outcome);
  const double moved_m = last_.is_valid ? (last_.T_S_L.inverse() * T_S_L()).translation().norm() : 0;
  travel_m_ += moved_m;
  cloud_travel_m_ += moved_m;
  if (present_shift_m(scan) > config_.spawn.max_correction_m) return spawn(scan, SpawnReason::kCorrection, outcome);
  if (config_.baseline) {
    return travel_m_ < config_.spawn.baseline_distance_m || spawn(scan, SpawnReason::kDistance, outcome);
  }
  filter_cloud();
  // One cloud a node is far from its neighbours already; scans of a turning sensor are not.
  const bool is_lone_cloud = scan.kind == Scan::Kind::kCloud;
  if (!is_lone_cloud) cloud_.advance(cloud_travel_m_);
  outcome.overlap_ratio = cloud_.overlap();
  const bool is_known_well = is_lone_cloud || cloud_.is_established();
  const bool is_strange = is_known_well && outcome.overlap_ratio <= config_.spawn.min_overlap;
  strange_scans_ = is_strange ? strange_scans_ + 1 : 0;
  is_threshold_ &= !is_known_well || is_strange;
  if (is_strange && (is_lone_cloud || strange_scans_ >= config_.spawn.min_scans)) {
    const bool goes_on = is_threshold_ && follows_threshold_ &&
                         outcome.overlap_ratio < kThresholdShare * config_.spawn.min_overlap &&
                         travel_m_ <= config_.spawn.max_threshold_m;
    if (is_lone_cloud || !goes_on) return spawn(scan, SpawnReason::kOverlap, outcome);
    begin_cloud();
    return true;
  }
  cloud_.add(cloud_travel_m_);
  const bool is_long = config_.spawn.max_travel_m > 0 && travel_m_ >= config_.spawn.max_travel_m;
  return !is_long || spare_slots_.empty() || spawn(scan, SpawnReason::kDistance, outcome);
}

bool LocalMapper::spawn(const Scan& scan, SpawnReason reason, ScanOutcome& outcome) {
  if (spare_slots_.empty()) {
    // Going on in the old submap is better than losing the scan.
    outcome.is_spawn_declined = active_ != nullptr;
    if (active_ == nullptr) outcome.refusal = ScanRefusal::kNoSubmapSlot;
    return active_ != nullptr;
  }
  outcome.finished = active_;
  outcome.spawned = reason;
  // What is around stays the same where only the way has become too long: the cloud goes on.
  const bool keeps_cloud = reason == SpawnReason::kDistance;
  const Pose T_M_cloud = keeps_cloud ? Pose(active_->T_M_S * T_S_C_) : Pose::Identity();
  const SubmapId continues = keeps_cloud ? active_->id : kNoSubmap;
  if (keeps_cloud) active_->is_continued = true;
  active_ = spare_slots_.back();
  spare_slots_.pop_back();
  active_->id = next_id_++;
  active_->continues = continues;
  active_->spawned = scan.stamp;
  // Parallel to M and on its grid of blocks: submaps that no correction moves apart share one grid.
  const double grid_m = config_.voxel.voxel_size_m * kBlockEdge;
  active_->T_M_S = Pose::Identity();
  active_->T_M_S.translation() = (T_M_L_.translation() / grid_m).array().round().matrix() * grid_m;
  active_->bind(scan.node, T_M_R_.inverse() * active_->T_M_S);

  travel_m_ = 0;
  follows_threshold_ = reason == SpawnReason::kOverlap && is_threshold_;
  T_S_C_ = keeps_cloud ? Pose(active_->T_M_S.inverse() * T_M_cloud) : Pose::Identity();
  is_threshold_ = is_threshold_ || !keeps_cloud;
  outcome.returns_declined = beams_.assign(scan, active_->T_M_S.inverse() * T_M_R_, config_.voxel);
  if (!config_.baseline && !keeps_cloud) {
    filter_cloud();
    begin_cloud();
  }
  return true;
}

void LocalMapper::begin_cloud() {
  cloud_.restart();
  cloud_travel_m_ = 0;
  strange_scans_ = 0;
}

void LocalMapper::integrate(const Scan& scan, ScanOutcome& outcome) {
  outcome.submap = active_->id;
  outcome.num_returns = beams_.num_returns();
  active_->note_scans(scan.node, T_M_R_.inverse() * active_->T_M_S);
  const Pose T_S_L_now = T_S_L();
  const IntegrationResult result =
      integrator_.integrate(beams_, T_S_L_now.translation().cast<float>(), pools_, active_->volume);
  const Eigen::Vector3f origin_S = T_S_L_now.translation().cast<float>();
  active_->path.add(origin_S);
  outcome.voxels_declined = result.voxels_declined;
  last_ = {true, scan.node, T_S_L_now, T_R_L_, scan.T_O_L};
}

}  // namespace cloister
