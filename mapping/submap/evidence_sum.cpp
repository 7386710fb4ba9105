#include "mapping/submap/evidence_sum.hpp"

#include <algorithm>
#include <cstdlib>

namespace cloister {

void EvidenceSum::add(LogOdds log_odds, SubmapId submap) {
  if (log_odds == kUnknownLogOdds) return;
  sum_ += log_odds;
  if (submap_ == kNoSubmap || std::abs(int{log_odds}) > std::abs(int{strongest_})) {
    strongest_ = log_odds;
    submap_ = submap;
  }
}

QueryAnswer EvidenceSum::answer(LogOdds lowest, LogOdds highest) const {
  if (submap_ == kNoSubmap) return {};
  const int sum = sum_ != 0 ? sum_ : strongest_ < 0 ? -1 : 1;
  const auto log_odds = static_cast<LogOdds>(std::clamp<int>(sum, lowest, highest));
  return {state_of(log_odds), log_odds, submap_};
}

}  // namespace cloister
