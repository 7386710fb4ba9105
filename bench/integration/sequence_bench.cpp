#include "bench/integration/sequence_bench.hpp"

#include <algorithm>
#include <utility>

#include "bench/integration/octomap_map.hpp"
#include "bench/integration/truth_points.hpp"

namespace cloister {
namespace {

// Scans kept in memory for OctoMap, at most; a quarter of a megabyte each.
constexpr std::int64_t kMaxComparedScans = 400;

/// The scans of a bench run, and the beams of those that are held out.
class Sequence {
 public:
  Sequence(const SequenceOptions& options, MissionScans scans)
      : options_(options), scans_(std::move(scans)) {}

  /// The next scan of the run, or null at its end; valid until the next call.
  Result<const PlacedScan*> next() {
    if (replayed_ < kept_.size()) return &kept_[replayed_++];
    if (options_.scans > 0 && num_read_ == options_.scans) return nullptr;
    auto found = scans_.next(current_);
    if (!found) return tl::unexpected(found.error());
    if (!*found) return nullptr;
    ++num_read_;
    return &current_;
  }

  /// Reads up to `count` scans ahead; next() returns them once more, from the first on.
  Result<void> keep(std::int64_t count) {
    while (static_cast<std::int64_t>(kept_.size()) < count) {
      auto scan = next();
      if (!scan) return tl::unexpected(scan.error());
      if (*scan == nullptr) break;
      kept_.push_back(**scan);
      replayed_ = kept_.size();
    }
    replayed_ = 0;
    return {};
  }

  [[nodiscard]] const std::vector<PlacedScan>& kept() const { return kept_; }
  [[nodiscard]] bool is_held_out(std::int64_t position) const {
    // In the middle of its stretch: the map has seen what lies on either side.
    return options_.hold_out > 0 && position % options_.hold_out == options_.hold_out / 2;
  }
  [[nodiscard]] const MissionScans& scans() const { return scans_; }

 private:
  const SequenceOptions& options_;
  MissionScans scans_;
  PlacedScan current_;
  std::vector<PlacedScan> kept_;
  std::size_t replayed_ = 0;
  std::int64_t num_read_ = 0;
};

Eigen::Vector3f sensor_at(const PlacedScan& placed, SensorTime stamp) {
  return sensor_pose(placed, stamp).translation().cast<float>();
}

/// Judges a map by the held-out scans and, where there is one, by the truth.
template <typename Map>
void judge(const Map& map, const SequenceOptions& options, const std::vector<Beam>& held_out,
           const std::vector<TruthPoint>& truth, const Eigen::Vector3d& origin_A,
           BenchResult& result) {
  const StateAt state_at = [&map](const Eigen::Vector3f& p_S) { return map.state(p_S); };
  const auto voxel_m = static_cast<float>(options.config.voxel.voxel_size_m);
  result.beams = {};
  for (const Beam& beam : held_out) judge_beam(beam, voxel_m, state_at, result.beams);
  if (!truth.empty()) result.truth = judge_points(truth, origin_A, state_at);
  result.map_bytes = map.bytes();
  result.observed_m3 = map.observed_m3();
}

void append_beams(const PlacedScan& placed, const SequenceOptions& options,
                  std::vector<Beam>& beams) {
  const std::vector<Beam> more = place_beams(placed, options.config.voxel, options.beam_stride);
  beams.insert(beams.end(), more.begin(), more.end());
}

/// OctoMap over the kept scans, until its time is used up. @return how many scans were read, held-out ones included
std::int64_t run_octomap(const SequenceOptions& options, const Sequence& sequence,
                         const std::vector<TruthPoint>& truth, BenchResult& result) {
  OctomapMap map(options.config.voxel);
  ThreadMeter meter;
  std::vector<Beam> held_out;
  double cpu_s = 0;
  std::int64_t position = 0;
  for (const PlacedScan& placed : sequence.kept()) {
    // One held-out scan is needed at least, for a judgement.
    const bool is_over =
        options.octomap_scans < 0 && cpu_s >= options.octomap_s && position >= options.hold_out;
    if (is_over) break;
    if (sequence.is_held_out(position++)) {
      append_beams(placed, options, held_out);
      continue;
    }
    // One origin a scan is all that OctoMap takes: the one halfway through.
    const SensorTime begin = placed.scan.poses.front().stamp;
    const SensorTime middle{begin.ns + (placed.scan.stamp - begin).ns / 2};
    map.prepare(place_beams(placed, options.config.voxel), sensor_at(placed, middle));
    meter.start();
    map.integrate();
    const Spent spent = meter.stop();
    cpu_s += 1e-9 * static_cast<double>(spent.cpu_ns);
    result.costs.push_back({placed.scan.index, placed.scan.stamp.ns, spent, 0});
  }
  judge(map, options, held_out, truth, sequence.scans().origin_A(), result);
  return position;
}

/// Ours over the whole sequence. @param compared  scans that OctoMap read; judged after them too when not 0
Result<void> run_cloister(const SequenceOptions& options, Sequence& sequence,
                          const std::vector<TruthPoint>& truth, std::int64_t compared,
                          SequenceResults& all) {
  CloisterMap map(options.config, sequence.scans().reader().max_pixels(),
                  options.config.memory.budget_bytes);
  ThreadMeter meter;
  all.context.cycle_kind = meter.cycle_kind();
  BenchResult result;
  result.library = "cloister";
  std::vector<Beam> held_out;
  for (std::int64_t position = 0;; ++position) {
    if (compared > 0 && position == compared) {
      BenchResult same = result;
      same.library = "cloister-same-scans";
      judge(map, options, held_out, truth, sequence.scans().origin_A(), same);
      all.results.push_back(std::move(same));
    }
    auto next = sequence.next();
    if (!next) return tl::unexpected(next.error());
    if (*next == nullptr) break;
    const PlacedScan& placed = **next;
    if (sequence.is_held_out(position)) {
      append_beams(placed, options, held_out);
      continue;
    }
    // Room for the row is made beforehand, outside of what is measured.
    ScanCost& cost = result.costs.emplace_back();
    cost.scan = placed.scan.index;
    cost.stamp_ns = placed.scan.stamp.ns;
    meter.start();
    cost.blocks_touched = map.integrate(placed.scan, placed.T_S_R);
    cost.spent = meter.stop();
    map.keep_memory_ahead();
  }
  judge(map, options, held_out, truth, sequence.scans().origin_A(), result);
  all.results.push_back(std::move(result));
  all.byte_shares = map.byte_shares();
  all.num_declined = map.num_declined();
  return {};
}

}  // namespace

Result<SequenceResults> run_sequence(const SequenceOptions& options) {
  auto scans = MissionScans::open(options.mission, options.config, options.poses, options.skip);
  if (!scans) return tl::unexpected(scans.error());
  Sequence sequence(options, std::move(*scans));
  const bool compares = options.octomap_scans != 0;
  const std::int64_t wanted = options.octomap_scans > 0 ? options.octomap_scans : kMaxComparedScans;
  if (auto kept = sequence.keep(compares ? wanted : 1); !kept) return tl::unexpected(kept.error());
  if (sequence.kept().empty()) {
    return fail(ErrorKind::kInput, options.mission.string() +
                                       ": no scan with a pose is left after --skip: skip fewer");
  }
  std::vector<TruthPoint> truth;
  if (sequence.scans().uses_truth() && options.truth_points > 0 &&
      std::filesystem::exists(options.mission / "ground_truth" / "mesh.ply")) {
    auto drawn = draw_truth_points(options.mission, options.truth_points);
    if (!drawn) return tl::unexpected(drawn.error());
    truth = std::move(*drawn);
  }

  SequenceResults all;
  all.context = context_here();
  all.context.mission = sequence.scans().reader().name();
  all.context.poses = sequence.scans().pose_source();
  all.context.voxel_m = options.config.voxel.voxel_size_m;
  all.context.max_range_m = options.config.voxel.max_range_m;
  all.context.warm_up = static_cast<std::size_t>(options.warm_up);

  BenchResult octomap;
  octomap.library = "octomap";
  const std::int64_t compared = compares ? run_octomap(options, sequence, truth, octomap) : 0;
  if (auto run = run_cloister(options, sequence, truth, compared, all); !run) {
    return tl::unexpected(run.error());
  }
  if (compares) {
    BenchResult& same = all.results.front();
    const double ours_ms = percentile(cpu_ms(same.costs), 0.5);
    if (ours_ms > 0) same.times_faster = percentile(cpu_ms(octomap.costs), 0.5) / ours_ms;
    all.results.insert(all.results.begin() + 1, std::move(octomap));
  }
  return all;
}

}  // namespace cloister
