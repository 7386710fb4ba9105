#include "mapping/submap/submap_cloud.hpp"

namespace cloister {
namespace {

constexpr std::size_t kMaxFilteredPoints = 1 << 15;
// Scans held back within one lag: closer together than this share of it, they would tell the same.
constexpr std::size_t kPendingPerLag = 8;

}  // namespace

SubmapCloud::SubmapCloud(const SpawnConfig& config, std::size_t max_points)
    : lag_m_(config.cloud_lag_m),
      cloud_(config.filter_m, max_points),
      // Cells are twice as wide as the filter's, so eight times as few on solid ground and four times on surfaces.
      covisibility_(2 * config.filter_m, config.min_covisibility, max_points / 4),
      scan_filter_(config.filter_m, kMaxFilteredPoints),
      pending_(kPendingPerLag + 1) {
  filtered_.reserve(kMaxFilteredPoints);
  for (Pending& pending : pending_) pending.points.reserve(kMaxFilteredPoints);
}

void SubmapCloud::filter(const ScanBeams& scan, const Eigen::Isometry3f& T_C_S) {
  scan_filter_.clear();
  filtered_.clear();
  for (std::size_t i = 0; i < scan.num_returns(); ++i) {
    const Eigen::Vector3f point_C = T_C_S * scan.return_S(i);
    if (scan_filter_.insert(point_C)) filtered_.push_back(point_C);
  }
}

double SubmapCloud::overlap() const {
  if (filtered_.empty()) return 1;
  std::size_t num_near = 0;
  for (const Eigen::Vector3f& point : filtered_) {
    num_near += covisibility_.is_established(point) && cloud_.has_neighbour(point);
  }
  return static_cast<double>(num_near) / static_cast<double>(filtered_.size());
}

void SubmapCloud::restart() {
  cloud_.clear();
  covisibility_.clear();
  pending_begin_ = pending_count_ = 0;
  absorb(filtered_);
}

void SubmapCloud::absorb(const std::vector<Eigen::Vector3f>& points) {
  for (const Eigen::Vector3f& point : points) cloud_.insert(point);
  covisibility_.add(points);
}

void SubmapCloud::advance(double travel_m) {
  while (pending_count_ > 0 && travel_m - pending_[pending_begin_].travel_m >= lag_m_) {
    absorb(pending_[pending_begin_].points);
    pending_begin_ = (pending_begin_ + 1) % pending_.size();
    --pending_count_;
  }
}

void SubmapCloud::add(double travel_m) {
  advance(travel_m);
  if (pending_count_ > 0) {
    const Pending& newest = pending_[(pending_begin_ + pending_count_ - 1) % pending_.size()];
    if (travel_m - newest.travel_m < lag_m_ / static_cast<double>(kPendingPerLag)) return;
  }
  if (pending_count_ == pending_.size()) return;
  Pending& slot = pending_[(pending_begin_ + pending_count_) % pending_.size()];
  slot.travel_m = travel_m;
  slot.points = filtered_;
  ++pending_count_;
}

std::size_t SubmapCloud::bytes() const {
  return cloud_.bytes() + covisibility_.bytes() + scan_filter_.bytes() +
         (pending_.size() + 1) * kMaxFilteredPoints * sizeof(Eigen::Vector3f);
}

}  // namespace cloister
