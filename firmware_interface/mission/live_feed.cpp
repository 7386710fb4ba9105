#include "firmware_interface/mission/live_feed.hpp"

#include <algorithm>
#include <limits>

namespace cloister {
namespace {

// No robot that maps with a spinning sensor moves or turns faster; the constant parts are noise between two samples.
constexpr double kMaxSpeedMPerS = 30.0;
constexpr double kMaxLeapM = 0.3;
constexpr double kMaxTurnRadPerS = 20.0;
constexpr double kMaxLeapRad = 0.3;
// Nodes ask for odometry of this far back; later ones are known from earlier revisions.
constexpr Duration kOdometryMemory{300'000'000'000};

}  // namespace

LiveFeed::LiveFeed(const Config& config, const std::optional<Pose>& T_B_L, std::size_t max_pixels,
                   std::size_t max_columns)
    : config_(config.scan),
      max_wait_(Duration::from_seconds(config.scan.max_odometry_wait_s).ns),
      has_T_B_L_(T_B_L.has_value()),
      placer_(config.scan, T_B_L.value_or(Pose::Identity())),
      keeper_(config.fusion.default_information),
      newest_scan_{std::numeric_limits<std::int64_t>::min()} {
  // One to fill, and one that `next` has swapped for another.
  for (std::size_t i = 0; i < kMaxWaitingScans + 2; ++i) {
    free_.push_back(std::make_unique<Scan>());
    free_.back()->reserve(max_pixels, max_columns, ScanPlacer::kMaxPoses);
  }
  spare_ = std::move(free_.back());
  free_.pop_back();
}

void LiveFeed::set_T_B_L(const Pose& T_B_L) {
  placer_.set_T_B_L(T_B_L);
  has_T_B_L_ = true;
}

bool LiveFeed::leaps(const StampedPose& from, const StampedPose& to) const {
  const double seconds = (to.stamp - from.stamp).seconds();
  if (seconds > config_.max_odometry_gap_s) return false;
  const Pose T_from_to = from.T_O_B.inverse() * to.T_O_B;
  return T_from_to.translation().norm() > kMaxLeapM + kMaxSpeedMPerS * seconds ||
         Eigen::AngleAxisd(T_from_to.linear()).angle() > kMaxLeapRad + kMaxTurnRadPerS * seconds;
}

void LiveFeed::push(const OdometrySample& sample) {
  counters_.add(FeedCause::kOdometry);
  if (!is_finite(sample.pose.T_O_B)) {
    counters_.add(FeedCause::kOdometryMalformed);
    return;
  }
  OdometryBuffer& odometry = placer_.odometry();
  const auto restart = [&] {
    placer_.restart_odometry();
    counters_.add(FeedCause::kOdometryRestart);
  };
  if (odometry_session_ && *odometry_session_ != sample.session) {
    restart();
    suspect_.reset();
  }
  odometry_session_ = sample.session;
  if (!odometry.samples().empty()) {
    const StampedPose& newest = odometry.samples().back();
    if (sample.pose.stamp < newest.stamp || (suspect_ && sample.pose.stamp <= suspect_->stamp)) {
      counters_.add(FeedCause::kOdometryBackwards);
      return;
    }
    if (leaps(newest, sample.pose)) {
      if (!suspect_ || leaps(*suspect_, sample.pose)) {
        if (suspect_) counters_.add(FeedCause::kOdometryOutlier);
        suspect_ = sample.pose;
        return;
      }
      restart();
      (void)placer_.odometry().try_push(*suspect_);
    } else if (suspect_) {
      counters_.add(FeedCause::kOdometryOutlier);
    }
    suspect_.reset();
  }
  (void)placer_.odometry().try_push(sample.pose);
  placer_.odometry().forget_before(sample.pose.stamp - kOdometryMemory);
}

void LiveFeed::push(const GraphUpdate& update, HostTime now) {
  if (keeper_.apply(update) != GraphCause::kApplied) return;
  WaitingGraph waiting{keeper_.graph(), {std::numeric_limits<std::int64_t>::min()}, now};
  for (const GraphNode& node : waiting.graph.nodes)
    waiting.newest_node = std::max(waiting.newest_node, node.stamp);
  graphs_.push_back(std::move(waiting));
}

void LiveFeed::push_scan(HostTime now) {
  Scan& scan = *spare_;
  counters_.add(FeedCause::kScans);
  scan.index = static_cast<std::uint64_t>(num_scans_read_++);
  num_returns_read_ += num_returns(scan);
  const Duration offset = Duration::from_seconds(config_.stamp_offset_s);
  scan.stamp = scan.stamp + offset;
  scan.last_packet = scan.last_packet + offset;
  for (SensorTime& stamp : scan.column_stamps) stamp = stamp + offset;
  if (scan.stamp <= newest_scan_) {
    counters_.add(FeedCause::kScanOutOfOrder);
    return;
  }
  newest_scan_ = scan.stamp;
  if (scans_.size() == kMaxWaitingScans) drop_front(FeedCause::kScanWaitingTooMany);
  scans_.push_back({std::move(spare_), now});
  spare_ = std::move(free_.back());
  free_.pop_back();
}

void LiveFeed::drop_front(FeedCause cause) {
  counters_.add(cause);
  free_.push_back(std::move(scans_.front().scan));
  scans_.pop_front();
}

bool LiveFeed::odometry_reaches(SensorTime stamp) const {
  if (!expects_odometry_) return true;
  const auto samples = placer_.odometry().samples();
  return !samples.empty() && samples.back().stamp >= stamp;
}

bool LiveFeed::graph_is_due(HostTime now) const {
  if (graphs_.empty()) return false;
  const WaitingGraph& graph = graphs_.front();
  if (!expects_odometry_ || has_waited(graph.arrived, now)) return true;
  const bool has_scan = !scans_.empty() && scans_.front().scan->stamp >= graph.graph.stamp;
  return has_scan && odometry_reaches(graph.newest_node);
}

LiveFeed::Item LiveFeed::next(HostTime now, Scan& scan) {
  while (true) {
    if (graph_is_due(now)) {
      graph_ = std::make_unique<GraphRevision>();
      graph_->revision = ++num_revisions_;
      graph_->graph = std::move(graphs_.front().graph);
      graphs_.pop_front();
      placer_.complete(*graph_);
      return Item::kGraph;
    }
    if (scans_.empty()) return Item::kNone;
    WaitingScan& front = scans_.front();
    if (!graphs_.empty() && graphs_.front().graph.stamp <= front.scan->stamp) return Item::kNone;
    const bool is_last_chance = has_waited(front.arrived, now);
    if (!is_last_chance && (!has_T_B_L_ || !odometry_reaches(front.scan->stamp)))
      return Item::kNone;
    if (!has_T_B_L_) {
      drop_front(FeedCause::kScanWithoutSensorPose);
      continue;
    }
    switch (placer_.place(*front.scan)) {
      case ScanPlacer::Placement::kPlaced:
        scan_arrived_ = front.arrived;
        std::swap(scan, *front.scan);
        free_.push_back(std::move(front.scan));
        scans_.pop_front();
        return Item::kScan;
      case ScanPlacer::Placement::kUntied:
        if (!is_last_chance) return Item::kNone;
        drop_front(FeedCause::kScanWithoutNode);
        break;
      case ScanPlacer::Placement::kTooLate:
        if (!is_last_chance) return Item::kNone;
        drop_front(FeedCause::kScanWithoutPose);
        break;
      case ScanPlacer::Placement::kTooEarly:
      case ScanPlacer::Placement::kGap:
        drop_front(FeedCause::kScanWithoutPose);
        break;
    }
  }
}

std::int64_t LiveFeed::num_scans_dropped() const {
  const std::uint64_t dropped =
      counters_[FeedCause::kScanWithoutPose] + counters_[FeedCause::kScanWithoutNode] +
      counters_[FeedCause::kScanWithoutSensorPose] + counters_[FeedCause::kScanOutOfOrder] +
      counters_[FeedCause::kScanWaitingTooMany];
  return static_cast<std::int64_t>(dropped);
}

}  // namespace cloister
