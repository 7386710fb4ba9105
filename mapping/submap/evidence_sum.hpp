#pragma once

#include "mapping/submap/submap.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

/// What the map knows about one point.
struct QueryAnswer {
  VoxelState state = VoxelState::kUnknown;
  LogOdds log_odds = kUnknownLogOdds;  ///< combined over all submaps that know the point
  SubmapId submap = kNoSubmap;  ///< the one with the most evidence; of equals the smallest id

  friend bool operator==(const QueryAnswer&, const QueryAnswer&) = default;
};

/// Adds up what several submaps know about one place.
class EvidenceSum {
 public:
  /// Submaps come by ascending id.
  void add(LogOdds log_odds, SubmapId submap);
  /// The sum, within the map's bounds. Evidence that cancels to exactly zero keeps the sign of the
  /// strongest submap with magnitude one, as a voxel does (see LogOdds).
  [[nodiscard]] QueryAnswer answer(LogOdds lowest, LogOdds highest) const;

 private:
  int sum_ = 0;
  LogOdds strongest_ = kUnknownLogOdds;
  SubmapId submap_ = kNoSubmap;
};

}  // namespace cloister
