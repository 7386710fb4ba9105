#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/files/stamped_pose.hpp"
#include "firmware_interface/mission/graph_keeper.hpp"
#include "firmware_interface/mission/scan_placer.hpp"
#include "firmware_interface/ouster/counters.hpp"
#include "mapping/core/config.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// What became of live scans and odometry.
enum class FeedCause {
  kScans,
  kScanWithoutPose,
  kScanWithoutNode,
  kScanWithoutSensorPose,
  kScanOutOfOrder,
  kScanWaitingTooMany,
  kOdometry,
  kOdometryBackwards,
  kOdometryMalformed,
  kOdometryOutlier,
  kOdometryRestart,
  kCount,
};

constexpr std::array<CounterName, 11> counter_names(FeedCause) {
  return {
      {{"scans_received"},
       {"scan_without_pose", true},  // odometry did not come in time, or has a gap there
       {"scan_without_node", true},  // odometry has begun anew and no graph ties it to the map yet
       {"scan_without_sensor_pose",
        true},                           // where the sensor sits on the body was not said in time
       {"scan_out_of_order", true},      // not younger than the one before
       {"scan_waiting_too_many", true},  // the oldest of those that wait for their poses made room
       {"odometry_received"},
       {"odometry_backwards", true},
       {"odometry_malformed", true},
       {"odometry_outlier", true},  // where nothing moves that fast, and the next sample is back
       {"odometry_restarts"}}};
}

/// A sample of odometry as it arrives.
struct OdometrySample {
  std::uint64_t session = 0;  ///< of one run of the odometry: another one has another frame
  StampedPose pose;
};

/// Brings what a robot sends into the order of its stamps: a scan leaves once odometry reaches it and the graphs that
/// are not younger have left; a graph leaves before the first scan that is not older than it. So a live mission runs as
/// a recorded one does. Nothing waits longer than `scan.max_odometry_wait_s` by the host's clock: a scan is then placed
/// by what odometry there is, or dropped.
///
/// Odometry that leaps further than anything moves is held aside for one sample: if the next one is back, it was an
/// outlier; else odometry has begun anew in another frame.
///
/// Threads: one at a time; no clock of its own. Scans take no allocation, graphs do.
class LiveFeed {
 public:
  using HostTime = std::chrono::steady_clock::time_point;
  enum class Item { kNone, kScan, kGraph };

  static constexpr std::size_t kMaxWaitingScans = 16;

  /// @param T_B_L  the sensor in the frame whose poses odometry and graph hold; nothing: scans wait for `set_T_B_L`
  LiveFeed(const Config& config, const std::optional<Pose>& T_B_L, std::size_t max_pixels,
           std::size_t max_columns);

  [[nodiscard]] bool has_T_B_L() const { return has_T_B_L_; }
  void set_T_B_L(const Pose& T_B_L);
  /// Nobody sends odometry: graphs leave at once, and a cloud waits for the node with its stamp.
  void expect_no_odometry() { expects_odometry_ = false; }

  void push(const OdometrySample& sample);
  /// Takes a graph in; `placer` is asked for the odometry at its nodes when it leaves.
  void push(const GraphUpdate& update, HostTime now);
  /// A scan to fill: geometry, kind, stamps, ranges, columns. Valid until the next call.
  [[nodiscard]] Scan& scan_to_fill() { return *spare_; }
  /// Takes in the scan that was filled.
  void push_scan(HostTime now);

  /// The next thing in order; a scan is swapped into `scan`, a graph is to be fetched with `take_graph`.
  [[nodiscard]] Item next(HostTime now, Scan& scan);
  [[nodiscard]] std::unique_ptr<GraphRevision> take_graph() { return std::move(graph_); }
  /// When the scan that `next` gave last had arrived.
  [[nodiscard]] HostTime scan_arrived() const { return scan_arrived_; }

  [[nodiscard]] std::size_t num_waiting_scans() const { return scans_.size(); }
  /// The newest graph that has come, whether it has left or not.
  [[nodiscard]] const PoseGraph& graph() const { return keeper_.graph(); }
  /// Where the present odometry frame lies, as ScanPlacer says.
  [[nodiscard]] const std::optional<Pose>& T_M_O() const { return placer_.T_M_O(); }
  [[nodiscard]] std::uint64_t graph_revision() const { return keeper_.revision(); }
  [[nodiscard]] std::int64_t num_scans_read() const { return num_scans_read_; }
  [[nodiscard]] std::int64_t num_returns_read() const { return num_returns_read_; }
  /// Scans that came in but never left.
  [[nodiscard]] std::int64_t num_scans_dropped() const;
  [[nodiscard]] const Counters<FeedCause>& counters() const { return counters_; }
  [[nodiscard]] const Counters<GraphCause>& graph_counters() const { return keeper_.counters(); }

 private:
  struct WaitingScan {
    std::unique_ptr<Scan> scan;
    HostTime arrived;
  };
  struct WaitingGraph {
    PoseGraph graph;
    SensorTime newest_node;
    HostTime arrived;
  };

  [[nodiscard]] bool leaps(const StampedPose& from, const StampedPose& to) const;
  [[nodiscard]] bool odometry_reaches(SensorTime stamp) const;
  [[nodiscard]] bool has_waited(HostTime arrived, HostTime now) const {
    return now - arrived >= max_wait_;
  }
  [[nodiscard]] bool graph_is_due(HostTime now) const;
  void drop_front(FeedCause cause);

  ScanConfig config_;
  std::chrono::nanoseconds max_wait_;
  bool has_T_B_L_;
  bool expects_odometry_ = true;
  ScanPlacer placer_;
  GraphKeeper keeper_;
  std::optional<std::uint64_t> odometry_session_;
  std::optional<StampedPose> suspect_;  ///< a sample that leapt

  std::unique_ptr<Scan> spare_;
  std::vector<std::unique_ptr<Scan>> free_;
  std::deque<WaitingScan> scans_;
  std::deque<WaitingGraph> graphs_;
  std::unique_ptr<GraphRevision> graph_;
  std::uint64_t num_revisions_ = 0;
  SensorTime newest_scan_;
  HostTime scan_arrived_;
  std::int64_t num_scans_read_ = 0;
  std::int64_t num_returns_read_ = 0;
  Counters<FeedCause> counters_;
};

}  // namespace cloister
