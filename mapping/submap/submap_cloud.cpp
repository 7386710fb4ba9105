#include "mapping/submap/submap_cloud.hpp"

namespace cloister {
namespace {

constexpr std::size_t kMaxFilteredPoints = 1 << 15;
// Scans held back within one lag: closer together than this share of it, they would tell the same.
constexpr std::size_t kPendingPerLag = 16;

}  // namespace

SubmapCloud::SubmapCloud(const SpawnConfig& config, std::size_t max_points)
    : lag_m_(config.cloud_lag_m),
      cloud_(config.filter_m, max_points),
      scan_filter_(config.filter_m, kMaxFilteredPoints),
      pending_(kPendingPerLag + 1) {
  filtered_.reserve(kMaxFilteredPoints);
  for (Pending& pending : pending_) pending.points.reserve(kMaxFilteredPoints);
}

void SubmapCloud::filter(const RayBundle& bundle, const Eigen::Isometry3f& T_C_S) {
  scan_filter_.clear();
  filtered_.clear();
  for (const Ray& ray : bundle.rays()) {
    if (!ray.is_return) continue;
    const Eigen::Vector3f point_C = T_C_S * ray.end_S;
    if (scan_filter_.insert(point_C)) filtered_.push_back(point_C);
  }
}

double SubmapCloud::overlap() const {
  if (filtered_.empty()) return 1;
  std::size_t num_near = 0;
  for (const Eigen::Vector3f& point : filtered_) num_near += cloud_.has_neighbour(point);
  return static_cast<double>(num_near) / static_cast<double>(filtered_.size());
}

void SubmapCloud::restart() {
  cloud_.clear();
  pending_begin_ = pending_count_ = 0;
  add_now();
}

void SubmapCloud::add_now() {
  for (const Eigen::Vector3f& point : filtered_) cloud_.insert(point);
}

void SubmapCloud::add(double travel_m) {
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

void SubmapCloud::advance(double travel_m) {
  while (pending_count_ > 0 && travel_m - pending_[pending_begin_].travel_m >= lag_m_) {
    for (const Eigen::Vector3f& point : pending_[pending_begin_].points) cloud_.insert(point);
    pending_begin_ = (pending_begin_ + 1) % pending_.size();
    --pending_count_;
  }
}

std::size_t SubmapCloud::bytes() const {
  return cloud_.bytes() + scan_filter_.bytes() +
         (pending_.size() + 1) * kMaxFilteredPoints * sizeof(Eigen::Vector3f);
}

}  // namespace cloister
