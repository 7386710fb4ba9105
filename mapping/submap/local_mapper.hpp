#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mapping/core/config.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/integrate/scan_integrator.hpp"
#include "mapping/scan/scan_beams.hpp"
#include "mapping/scan/scan.hpp"
#include "mapping/submap/submap.hpp"
#include "mapping/submap/submap_cloud.hpp"

namespace cloister {

/// Why a scan began a new submap; kNone when it did not.
enum class SpawnReason : std::uint8_t { kNone, kFirst, kOverlap, kCorrection, kLoopClosure, kDistance };

/// Why a scan was not integrated; kNone when it was.
enum class ScanRefusal : std::uint8_t { kNone, kNoPose, kUnknownNode, kNoSubmapSlot };

/// What became of one scan.
struct ScanOutcome {
  ScanRefusal refusal = ScanRefusal::kNone;
  SpawnReason spawned = SpawnReason::kNone;
  bool is_spawn_declined = false;    ///< it should have begun a submap, but for want of a slot went into the old one
  SubmapId submap = kNoSubmap;
  NodeId node = kNoNode;
  double overlap_ratio = 1;          ///< R_point against the active submap's cloud
  Pose T_M_L = Pose::Identity();     ///< where the sensor was at the scan's stamp
  std::size_t num_returns = 0;
  std::size_t returns_declined = 0;  ///< beams beyond the capacity of a scan
  std::size_t voxels_declined = 0;
  Submap* finished = nullptr;        ///< the submap that this scan closed; it now belongs to the caller
  bool is_known_place = false;       ///< the active submap should be closed now: what is known of the place can join it
};

/// The integration thread's part of the method: places each scan, decides whether it begins a new submap, and
/// integrates it into the active one.
///
/// Threads: one owner. Real-time: no member allocates after construction, locks or does I/O.
class LocalMapper {
 public:
  /// @param workers  share in integrating a scan; may be null
  LocalMapper(const Config& config, VoxelStore& store, ScanWorkers* workers = nullptr);

  /// Hands over an unused slot for a submap to come.
  void give_slot(Submap* slot) { spare_slots_.push_back(slot); }

  /// Bends the active submap to a new revision, which must live until the next one has been set.
  /// @return true when a new loop closure joins the active submap to an older one and the sensor has moved far enough
  ///         in it (FusionConfig::min_active_travel_m): it should be closed now, so that the two can be fused
  [[nodiscard]] bool set_graph(const GraphRevision* revision);
  /// Closes the active submap; null when there is none. The next scan begins a new one for the reason given, unless
  /// one is adopted first.
  [[nodiscard]] Submap* close(SpawnReason next_reason);
  /// Goes on in a submap that came back from a fusion with the one closed last. Where surfaces have laid the two otherwise
  /// than the graph does, scans go on where the closed one's went, until the next submap.
  /// @param T_S_closed  pose of the closed submap's frame in the fused one
  /// @return what was active meanwhile, or null; it now belongs to the caller
  [[nodiscard]] Submap* adopt(Submap* fused, const Pose& T_S_closed);

  /// One scan in three steps, so that each can be timed: place it and correct its motion; decide on a new submap;
  /// integrate. A step that returns false has refused the scan (see outcome.refusal), and the rest is skipped.
  [[nodiscard]] bool place(const Scan& scan, ScanOutcome& outcome);
  [[nodiscard]] bool check_spawn(const Scan& scan, ScanOutcome& outcome);
  void integrate(const Scan& scan, ScanOutcome& outcome);

  [[nodiscard]] const Submap* active() const { return active_; }
  [[nodiscard]] VoxelPools& pools() { return pools_; }
  [[nodiscard]] const SubmapCloud& cloud() const { return cloud_; }
  [[nodiscard]] SubmapId num_spawned() const { return next_id_; }

 private:
  /// The last scan integrated into the active submap, to notice when the graph shifts the present place.
  struct LastScan {
    bool is_valid = false;
    NodeId node = kNoNode;
    Pose T_S_L = Pose::Identity();
    Pose T_R_L = Pose::Identity();
    std::optional<Pose> T_O_L;
  };

  /// The submap closed last, as long as it may come back: where scans went in it, as of the newest revision.
  struct Closed {
    SubmapAnchors anchors;
    Pose T_S_A = Pose::Identity();
    Pose T_M_A = Pose::Identity();
  };

  [[nodiscard]] double present_shift_m(const Scan& scan) const;
  [[nodiscard]] bool spawn(const Scan& scan, SpawnReason reason, ScanOutcome& outcome);
  /// True once the active submap is old enough to ask, and again when it has become twice as old, where the sensor is
  /// back beside a node of an older submap.
  [[nodiscard]] bool comes_back();
  /// Where the active submap is for the scans that come: where the graph has it, but for what a fusion found out.
  [[nodiscard]] Pose T_M_A() const { return active_->T_M_S * T_S_A_; }
  [[nodiscard]] Pose T_S_L() const { return T_M_A().inverse() * T_M_L_; }
  void filter_cloud();
  /// With the filtered scan.
  void begin_cloud();

  Config config_;
  VoxelPools pools_;
  ScanIntegrator integrator_;
  ScanBeams beams_;
  SubmapCloud cloud_;
  std::vector<Submap*> spare_slots_;
  const GraphRevision* revision_ = nullptr;
  Submap* active_ = nullptr;
  SubmapId next_id_ = 0;
  SpawnReason next_reason_ = SpawnReason::kFirst;
  double travel_m_ = 0;                   ///< since the active submap was spawned or adopted
  double next_return_m_ = 0;              ///< of that: before, a known place is not asked for
  int strange_scans_ = 0;                 ///< the newest ones in a row whose overlap was too little
  bool is_threshold_ = true;              ///< no scan has been at home in the active submap's cloud yet
  bool follows_threshold_ = false;        ///< nor had any been in that of the submap before
  double cloud_travel_m_ = 0;             ///< since the cloud was begun: it goes on in an adopted submap
  Pose T_S_C_ = Pose::Identity();         ///< frame of the cloud in the active submap's
  Pose T_S_A_ = Pose::Identity();         ///< see T_M_A
  Closed closed_;
  LastScan last_;

  // The scan on its way through the three steps.
  Pose T_M_R_ = Pose::Identity();
  Pose T_M_L_ = Pose::Identity();
  Pose T_R_L_ = Pose::Identity();
};

}  // namespace cloister
