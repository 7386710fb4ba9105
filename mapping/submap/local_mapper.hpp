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
enum class SpawnReason : std::uint8_t { kNone, kFirst, kOverlap, kCorrection, kDistance };

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
  void set_graph(const GraphRevision* revision);
  /// Closes the active submap; null when there is none.
  [[nodiscard]] Submap* close();

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

  [[nodiscard]] double present_shift_m(const Scan& scan) const;
  [[nodiscard]] bool spawn(const Scan& scan, SpawnReason reason, ScanOutcome& outcome);
  [[nodiscard]] Pose T_S_L() const { return active_->T_M_S.inverse() * T_M_L_; }
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
  double travel_m_ = 0;                   ///< since the active submap was spawned
  int strange_scans_ = 0;                 ///< the newest ones in a row whose overlap was too little
  bool is_threshold_ = true;              ///< no scan has been at home in the active submap's cloud yet
  bool follows_threshold_ = false;        ///< nor had any been in that of the submap before
  double cloud_travel_m_ = 0;             ///< since the cloud was begun: it may go on in the next submap
  Pose T_S_C_ = Pose::Identity();         ///< frame of the cloud in the active submap's
  LastScan last_;

  // The scan on its way through the three steps.
  Pose T_M_R_ = Pose::Identity();
  Pose T_M_L_ = Pose::Identity();
  Pose T_R_L_ = Pose::Identity();
};

}  // namespace cloister
