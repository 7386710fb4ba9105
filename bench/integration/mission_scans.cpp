#include "bench/integration/mission_scans.hpp"

#include <algorithm>
#include <utility>

#include "firmware_interface/files/tum_file.hpp"
#include "mapping/voxel/voxel.hpp"

namespace cloister {

Result<MissionScans> MissionScans::open(const std::filesystem::path& mission, const Config& config,
                                        PoseSource source, std::int64_t skip) {
  MissionScans scans;
  scans.config_ = config;
  scans.skip_ = skip;
  auto reader = MissionReader::open(mission, config);
  if (!reader) return tl::unexpected(reader.error());
  scans.reader_ = std::move(*reader);
  const std::filesystem::path truth_file = mission / "ground_truth" / "trajectory.tum";
  if (source == PoseSource::kTruth ||
      (source == PoseSource::kAuto && std::filesystem::exists(truth_file))) {
    auto samples = load_tum(truth_file);
    if (!samples) return tl::unexpected(samples.error());
    scans.truth_.emplace(std::move(*samples));
    scans.pose_source_ = "truth";
  }
  return scans;
}

std::optional<Pose> MissionScans::place(Scan& scan) {
  if (truth_) {
    SensorTime begin = scan.stamp;
    for (std::size_t i = 0; i < scan.column_valid.size(); ++i) {
      if (scan.column_valid[i]) begin = std::min(begin, scan.column_stamps[i]);
    }
    const OdometryBuffer::Limits limits{Duration::from_seconds(1.0), Duration::from_seconds(0.1)};
    if (truth_->cover(begin, scan.stamp, limits, MissionReader::kMaxPoses, scan.poses) !=
        OdometryBuffer::Coverage::kCovered) {
      return std::nullopt;
    }
    scan.node = kNoNode;
    return Pose::Identity();
  }
  if (scan.T_O_L) {
    // The last sample of `poses` is the pose at the scan's stamp, as T_O_L is.
    return *scan.T_O_L * scan.poses.back().T_R_L.inverse();
  }
  const GraphNode* node = graph_ != nullptr ? graph_->node(scan.node) : nullptr;
  if (node == nullptr) return std::nullopt;
  pose_source_ = "graph";
  return node->T_M_N;
}

Result<bool> MissionScans::next(PlacedScan& placed) {
  while (true) {
    auto item = reader_->next(placed.scan);
    if (!item) return tl::unexpected(item.error());
    if (*item == MissionReader::Item::kEnd) return false;
    if (*item == MissionReader::Item::kGraph) {
      graph_ = reader_->take_graph();
      continue;
    }
    if (skip_ > 0) {
      --skip_;
      continue;
    }
    const auto T_A_R = place(placed.scan);
    if (!T_A_R) continue;
    placed.T_S_R = *T_A_R;
    if (!origin_A_) {
      const double grid_m = config_.voxel.voxel_size_m * kBlockEdge;
      const Eigen::Vector3d p_A = sensor_pose(placed, placed.scan.stamp).translation();
      origin_A_ = (p_A / grid_m).array().round().matrix() * grid_m;
    }
    placed.T_S_R.translation() -= *origin_A_;
    return true;
  }
}

}  // namespace cloister
