#include "mapping/integrate/scan_marks.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <climits>
#include <cmath>
#include <cstring>
#include <limits>

namespace cloister {
namespace {

// Four lanes of the compiler's own vectors: SSE on x86, NEON on ARM.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

// Returns whose voxels are found at once.
constexpr std::size_t kBatch = 256;

/// Voxel of each coordinate along one axis: rounded down, without the library call that rounding is on old processors.
void voxels_along(const float* metres, std::size_t count, float voxels_per_metre,
                  std::int32_t* voxels) {
  for (std::size_t i = 0; i < count; ++i) {
    const float place = metres[i] * voxels_per_metre;
    const auto towards_zero = static_cast<std::int32_t>(place);
    voxels[i] = towards_zero - static_cast<std::int32_t>(place < static_cast<float>(towards_zero));
  }
}

// Of the chunks that a scan reaches: outdoors it crosses about eight blocks of each at the least.
constexpr std::size_t kMinBlocksPerChunk = 8;

}  // namespace

ScanMarks::ScanMarks(double voxel_size_m, double max_range_m, double slack_m,
                     std::size_t max_blocks)
    : voxels_per_metre_(static_cast<float>(1.0 / voxel_size_m)), max_blocks_(max_blocks) {
  const double chunk_m = voxel_size_m * kBlockEdge * kChunkEdge;
  window_edge_ = 2 * static_cast<int>(std::ceil((max_range_m + slack_m) / chunk_m)) + 2;
  window_origin_.setZero();
  const std::size_t window_chunks =
      static_cast<std::size_t>(window_edge_) * window_edge_ * window_edge_;
  max_chunks_ = std::min(window_chunks, max_blocks / kMinBlocksPerChunk);
  window_.assign(window_chunks, 0);
  used_chunks_.reserve(max_chunks_);
  chunk_slots_ = std::make_unique_for_overwrite<Slot[]>(max_chunks_ * kChunkBlocks);
  blocks_ = std::make_unique_for_overwrite<Marked[]>(max_blocks);
}

void ScanMarks::restart(const Eigen::Vector3f& centre_S) {
  for (const std::uint32_t index : used_chunks_) window_[index] = 0;
  used_chunks_.clear();
  num_blocks_ = 0;
  num_declined_ = 0;
  for (int a = 0; a < 3; ++a) {
    const int centre_voxel = static_cast<int>(std::floor(centre_S[a] * voxels_per_metre_));
    window_origin_[a] = (centre_voxel >> (2 * kBlockShift)) - window_edge_ / 2;
  }
}

std::size_t ScanMarks::window_index(const ChunkCoord& chunk) const {
  const ChunkCoord place = chunk - window_origin_;
  const auto edge = static_cast<unsigned>(window_edge_);
  if (static_cast<unsigned>(place.x()) >= edge || static_cast<unsigned>(place.y()) >= edge ||
      static_cast<unsigned>(place.z()) >= edge) {
    return window_.size();
  }
  return static_cast<std::size_t>(place.x()) +
         edge * (static_cast<std::size_t>(place.y()) + edge * static_cast<std::size_t>(place.z()));
}

const ScanMarks::Slot* ScanMarks::find_chunk(const ChunkCoord& chunk) const {
  const std::size_t index = window_index(chunk);
  if (index == window_.size() || window_[index] == 0) return nullptr;
  return &chunk_slots_[(window_[index] - 1) * std::size_t{kChunkBlocks}];
}

ScanMarks::Marked* ScanMarks::find_or_make(const BlockCoord& block) {
  const std::size_t index = window_index(parent_coord(block));
  if (index == window_.size()) return nullptr;
  Slot& chunk_slot = window_[index];
  if (chunk_slot == 0) {
    if (used_chunks_.size() == max_chunks_) return nullptr;
    std::memset(&chunk_slots_[used_chunks_.size() * kChunkBlocks], 0, kChunkBlocks * sizeof(Slot));
    used_chunks_.push_back(static_cast<std::uint32_t>(index));
    chunk_slot = static_cast<Slot>(used_chunks_.size());
  }
  Slot& block_slot =
      chunk_slots_[(chunk_slot - 1) * std::size_t{kChunkBlocks} + index_in_block(block)];
  if (block_slot == 0) {
    if (num_blocks_ == max_blocks_) return nullptr;
    Marked& fresh = blocks_[num_blocks_++];
    fresh.coord = block;
    fresh.is_applied = false;
    fresh.hit = fresh.crossed = BlockBits{};
    block_slot = static_cast<Slot>(num_blocks_);
  }
  return &blocks_[block_slot - 1];
}

void ScanMarks::mark_returns(const ScanBeams& scan) {
  Marked* marked = nullptr;
  // The last of the batch before comes first: nothing is that far away at the beginning.
  std::array<std::int32_t, kBatch + 1> x, y, z;
  std::array<std::int32_t, kBatch> leaves_voxel, place, fresh;
  x[0] = y[0] = z[0] = INT_MAX;
  for (std::size_t first = 0; first < scan.num_returns(); first += kBatch) {
    const std::size_t count = std::min(kBatch, scan.num_returns() - first);
    voxels_along(scan.x_S() + first, count, voxels_per_metre_, x.data() + 1);
    voxels_along(scan.y_S() + first, count, voxels_per_metre_, y.data() + 1);
    voxels_along(scan.z_S() + first, count, voxels_per_metre_, z.data() + 1);
    for (std::size_t i = 0; i < count; ++i) {
      leaves_voxel[i] = (x[i + 1] ^ x[i]) | (y[i + 1] ^ y[i]) | (z[i + 1] ^ z[i]);
      place[i] = index_in_block(x[i + 1], y[i + 1], z[i + 1]);
    }
    // Neighbouring beams end in the same voxel more often than not: once is enough, and spares waiting for the word that
    // was just written. Which of them do is nothing that a branch could foretell.
    std::size_t num_fresh = 0;
    for (std::size_t i = 0; i < count; ++i) {
      fresh[num_fresh] = static_cast<std::int32_t>(i);
      num_fresh += leaves_voxel[i] != 0;
    }
    for (std::size_t k = 0; k < num_fresh; ++k) {
      const auto i = static_cast<std::size_t>(fresh[k]);
      if (leaves_voxel[i] >> kBlockShift != 0) {
        marked = find_or_make(parent_coord({x[i + 1], y[i + 1], z[i + 1]}));
      }
      if (marked == nullptr) {
        ++num_declined_;
        continue;
      }
      marked->hit.word[place[i] >> 6] |= std::uint64_t{1} << (place[i] & 63);
    }
    x[0] = x[count];
    y[0] = y[count];
    z[0] = z[count];
  }
}

void ScanMarks::mark_crossed(const Ray& ray) {
  const Eigen::Vector3f start = ray.origin_S * voxels_per_metre_;
  const Eigen::Vector3f end = ray.end_S * voxels_per_metre_;

  const float length = (end - start).norm();
  const float free_length = ray.free_m * voxels_per_metre_;
  if (length <= 0 || free_length <= 0) return;

  // Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing" (1987), in units of voxels, three axes at
  // once and without a branch on the axis, which no processor can foretell: `ahead` holds the lengths along the ray at
  // which it enters the next voxel along x, y and z, and `nearest` the least of them in every lane.
  const Eigen::Vector3f slope = (end - start) / length;
  Float4 ahead = {0, 0, 0, std::numeric_limits<float>::infinity()};
  Float4 apart = {0, 0, 0, 0};
  Int4 towards = {0, 0, 0, 0};
  Int4 local = {0, 0, 0, 0};
  BlockCoord block;
  for (int a = 0; a < 3; ++a) {
    const float at = start[a];
    const float cell = std::floor(at);
    towards[a] = slope[a] < 0 ? -1 : 1;
    apart[a] = slope[a] == 0 ? std::numeric_limits<float>::infinity() : 1 / std::abs(slope[a]);
    ahead[a] = slope[a] == 0 ? std::numeric_limits<float>::infinity()
                             : (slope[a] < 0 ? at - cell : cell + 1 - at) * apart[a];
    block[a] = static_cast<int>(cell) >> kBlockShift;
    local[a] = static_cast<int>(cell) & (kBlockEdge - 1);
  }
  Marked* marks = find_or_make(block);
  while (marks != nullptr) {
    int outside = 0;
    do {
      marks->crossed.word[local[2]] |= std::uint64_t{1} << (local[0] | (local[1] << kBlockShift));
      const Float4 one_on = __builtin_shufflevector(ahead, ahead, 1, 2, 0, 3);
      const Float4 two_on = __builtin_shufflevector(ahead, ahead, 2, 0, 1, 3);
      const Float4 lesser = one_on < two_on ? one_on : two_on;
      const Float4 nearest = ahead < lesser ? ahead : lesser;
      if (nearest[0] >= free_length) return;
      const Int4 entered = ahead == nearest;
      ahead += std::bit_cast<Float4>(entered & std::bit_cast<Int4>(apart));
      local += entered & towards;
      outside = (local[0] | local[1] | local[2]) & ~(kBlockEdge - 1);
    } while (outside == 0);
    block += BlockCoord(local[0] >> kBlockShift, local[1] >> kBlockShift, local[2] >> kBlockShift);
    local &= kBlockEdge - 1;
    marks = find_or_make(block);
  }
  ++num_declined_;
}

}  // namespace cloister
