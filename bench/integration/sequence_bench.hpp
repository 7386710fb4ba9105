#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "bench/integration/bench_result.hpp"
#include "bench/integration/cloister_map.hpp"
#include "bench/integration/mission_scans.hpp"

namespace cloister {

/// What to run over which scans.
struct SequenceOptions {
  std::filesystem::path mission;
  Config config;
  PoseSource poses = PoseSource::kAuto;
  std::int64_t skip = 0;
  std::int64_t scans = 0;      ///< scans to read after `skip`, held-out ones included; 0 = all
  std::int64_t hold_out = 10;  ///< every so many-th scan is kept for judging; 0 = none
  int beam_stride = 7;         ///< of a held-out scan, every so many-th pixel is judged
  std::int64_t octomap_scans =
      -1;  ///< scans to read for the comparison; -1 = until octomap_s is used up, and one scan is held out
  double octomap_s = 60;
  std::int64_t warm_up = 20;
  std::size_t truth_points = 100'000;  ///< 0 = do not compare with the truth
};

/// The whole bench of one mission: OctoMap over the first scans, then ours over the same and on to the end.
struct SequenceResults {
  BenchContext context;  ///< all but the commit
  std::vector<BenchResult> results;
  std::vector<ByteShare> byte_shares;  ///< of our map at the end
  std::size_t num_declined = 0;        ///< updates that our full pools did not take
};

/// Runs everything in the calling thread. Errors: as the mission's reader; kInput when it has no scan to integrate
[[nodiscard]] Result<SequenceResults> run_sequence(const SequenceOptions& options);

}  // namespace cloister
