#include "mapping/integrate/ray_marker.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace cloister {

RayMarker::RayMarker(double voxel_size_m, double max_range_m, double slack_m, std::size_t max_blocks)
    : voxels_per_metre_(static_cast<float>(1.0 / voxel_size_m)), max_blocks_(max_blocks) {
  const double chunk_m = voxel_size_m * kBlockEdge * kChunkEdge;
  window_edge_ = 2 * static_cast<int>(std::ceil((max_range_m + slack_m) / chunk_m)) + 2;
  window_origin_.setZero();
  const std::size_t window_chunks = static_cast<std::size_t>(window_edge_) * window_edge_ * window_edge_;
  max_chunks_ = std::min(window_chunks, max_blocks);
  window_.assign(window_chunks, 0);
  used_chunks_.reserve(max_chunks_);
  chunk_slots_.assign(max_chunks_ * kChunkBlocks, 0);
  blocks_ = std::make_unique_for_overwrite<Marked[]>(max_blocks);
}

void RayMarker::clear() {
  for (std::size_t i = 0; i < used_chunks_.size(); ++i) {
    window_[used_chunks_[i]] = 0;
    std::memset(&chunk_slots_[i * kChunkBlocks], 0, kChunkBlocks * sizeof(Slot));
  }
  used_chunks_.clear();
  num_blocks_ = 0;
  num_declined_ = 0;
}

BlockMarks* RayMarker::find_or_make(const BlockCoord& block) {
  const ChunkCoord chunk = parent_coord(block) - window_origin_;
  const auto edge = static_cast<unsigned>(window_edge_);
  if (static_cast<unsigned>(chunk.x()) >= edge || static_cast<unsigned>(chunk.y()) >= edge ||
      static_cast<unsigned>(chunk.z()) >= edge) {
    return nullptr;
  }
  const std::uint32_t window_index =
      static_cast<std::uint32_t>(chunk.x()) + edge * (static_cast<std::uint32_t>(chunk.y()) +
                                                      edge * static_cast<std::uint32_t>(chunk.z()));
  Slot& chunk_slot = window_[window_index];
  if (chunk_slot == 0) {
    if (used_chunks_.size() == max_chunks_) return nullptr;
    used_chunks_.push_back(window_index);
    chunk_slot = static_cast<Slot>(used_chunks_.size());
  }
  Slot& block_slot = chunk_slots_[(chunk_slot - 1) * std::size_t{kChunkBlocks} + index_in_block(block)];
  if (block_slot == 0) {
    if (num_blocks_ == max_blocks_) return nullptr;
    Marked& fresh = blocks_[num_blocks_++];
    fresh.coord = block;
    std::memset(&fresh.marks, 0, sizeof(fresh.marks));
    block_slot = static_cast<Slot>(num_blocks_);
  }
  return &blocks_[block_slot - 1].marks;
}

bool RayMarker::walk(const Ray& ray) {
  const Eigen::Vector3f start = ray.origin_S * voxels_per_metre_;
  const Eigen::Vector3f end = ray.end_S * voxels_per_metre_;

  VoxelCoord hit_voxel(static_cast<int>(std::floor(end.x())), static_cast<int>(std::floor(end.y())),
                       static_cast<int>(std::floor(end.z())));
  if (ray.is_return) {
    BlockMarks* marks = find_or_make(parent_coord(hit_voxel));
    if (marks == nullptr) return false;
    marks->hit[hit_voxel.z() & 7] |= std::uint64_t{1} << ((hit_voxel.x() & 7) | ((hit_voxel.y() & 7) << 3));
  }

  // Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing" (1987), in units of voxels: `next[a]` is
  // the length along the ray at which it enters the next voxel along axis a.
  const Eigen::Vector3f span = end - start;
  const float length = span.norm();
  const float free_length = ray.free_m * voxels_per_metre_;
  if (length <= 0) return true;
  int voxel[3];
  int step[3];
  float next[3];
  float delta[3];
  for (int a = 0; a < 3; ++a) {
    const float cell = std::floor(start[a]);
    const float slope = span[a] / length;
    voxel[a] = static_cast<int>(cell);
    step[a] = slope < 0 ? -1 : 1;
    if (slope == 0) {
      next[a] = delta[a] = std::numeric_limits<float>::infinity();
    } else {
      delta[a] = 1 / std::abs(slope);
      next[a] = (slope < 0 ? start[a] - cell : cell + 1 - start[a]) * delta[a];
    }
  }
  BlockCoord block(voxel[0] >> kBlockShift, voxel[1] >> kBlockShift, voxel[2] >> kBlockShift);
  BlockMarks* marks = find_or_make(block);
  while (marks != nullptr) {
    marks->free[voxel[2] & 7] |= std::uint64_t{1} << ((voxel[0] & 7) | ((voxel[1] & 7) << 3));
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    if (next[axis] >= free_length) return true;
    next[axis] += delta[axis];
    voxel[axis] += step[axis];
    const int moved_to = voxel[axis] >> kBlockShift;
    if (moved_to != block[axis]) {
      block[axis] = moved_to;
      marks = find_or_make(block);
    }
  }
  return false;
}

void RayMarker::mark(const std::vector<Ray>& rays, const Eigen::Vector3f& centre_S) {
  clear();
  for (int a = 0; a < 3; ++a) {
    const int centre_voxel = static_cast<int>(std::floor(centre_S[a] * voxels_per_metre_));
    window_origin_[a] = (centre_voxel >> (2 * kBlockShift)) - window_edge_ / 2;
  }
  for (const Ray& ray : rays) num_declined_ += !walk(ray);
}

}  // namespace cloister
