#include "mapping/overlap/voxel_overlap.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace cloister {
namespace {

constexpr int kChunkVoxels = kBlockEdge * kChunkEdge;

// Volumes of up to so many blocks, a few rooms, are compared voxel by voxel. Of larger ones samples tell the ratio to a
// few thousandths.
constexpr std::size_t kMaxDenseBlocks = 2048;

/// Looks up voxels of a volume B at the places of another grid A: the nearest voxel of B for each voxel centre of A. The
/// chunks of B that a chunk of A reaches into, 3x3x3 at the most, are fetched at once.
class ChunkSampler {
 public:
  ChunkSampler(const VoxelStore& store, const Volume& volume_B, const Pose& T_B_A,
               double voxel_size_m)
      : store_(store),
        volume_(volume_B),
        R_B_A_(T_B_A.linear()),
        offset_(T_B_A.translation() / voxel_size_m) {}

  /// Fetches what lies under a chunk of A. @return false when B knows nothing there
  bool enter(const ChunkCoord& chunk_A) {
    const Eigen::Vector3d first =
        R_B_A_ * (chunk_A.cast<double>() * kChunkVoxels + Eigen::Vector3d::Constant(0.5)) + offset_;
    const Eigen::Vector3d span = R_B_A_ * Eigen::Vector3d::Constant(kChunkVoxels - 1);
    const Eigen::Vector3d half =
        R_B_A_.cwiseAbs() * Eigen::Vector3d::Constant(0.5 * (kChunkVoxels - 1) + kMarginVox);
    const ChunkCoord low = chunk_at(first + 0.5 * span - half);
    size_ = chunk_at(first + 0.5 * span + half) - low + ChunkCoord::Ones();
    // From the lowest chunk: far from B's origin single precision would not do.
    first_ = (first - low.cast<double>() * kChunkVoxels).cast<float>();
    bool is_known = false;
    const Chunk** chunk = chunks_.data();
    for (int z = 0; z < size_.z(); ++z) {
      for (int y = 0; y < size_.y(); ++y) {
        for (int x = 0; x < size_.x(); ++x, ++chunk) {
          const PoolIndex index = volume_.find_chunk(store_, low + ChunkCoord(x, y, z));
          *chunk = index == kNoIndex ? nullptr : &store_.chunk(index);
          is_known |= *chunk != nullptr;
        }
      }
    }
    return is_known;
  }

  /// Centre of the entered chunk's first voxel, voxels of B.
  [[nodiscard]] const Eigen::Vector3f& first() const { return first_; }

  /// B's value at a place within the entered chunk, as `first` is.
  [[nodiscard]] LogOdds at(const Eigen::Vector3f& place) const {
    // Never below the lowest chunk: rounding towards zero is rounding down.
    const auto x = static_cast<int>(place.x()), y = static_cast<int>(place.y()),
               z = static_cast<int>(place.z());
    const Chunk* chunk =
        chunks_[x / kChunkVoxels + size_.x() * (y / kChunkVoxels + size_.y() * (z / kChunkVoxels))];
    if (chunk == nullptr) return kUnknownLogOdds;
    const std::uint32_t block =
        chunk->places[index_in_block(x >> kBlockShift, y >> kBlockShift, z >> kBlockShift)];
    return Volume::view_of(store_, block).at(index_in_block(x, y, z));
  }

 private:
  // Rounding of a voxel centre in single precision must not leave the fetched chunks.
  static constexpr double kMarginVox = 0.01;

  static ChunkCoord chunk_at(const Eigen::Vector3d& p_vox) {
    return (p_vox / kChunkVoxels).array().floor().matrix().cast<int>();
  }

  const VoxelStore& store_;
  const Volume& volume_;
  Eigen::Matrix3d R_B_A_;
  Eigen::Vector3d offset_;  ///< A's origin in B, voxels
  Eigen::Vector3f first_;
  ChunkCoord size_;
  std::array<const Chunk*, 27> chunks_;
};

/// The voxels of a block in which volumes are compared: all, or one of sixteen, as a chessboard's white or black fields in
/// one of its slices. Those lie in one line of memory, and fetching lines is what a comparison takes longest for.
class SampledVoxels {
 public:
  struct Voxel {
    Eigen::Vector3f offset;  ///< from the block's first voxel, in B
    int index;               ///< in the block
  };

  SampledVoxels(const Eigen::Matrix3f& R_B_A, bool is_sparse)
      : num_sets_(is_sparse ? kSets : 1), per_set_(kBlockVoxels / num_sets_) {
    std::array<int, kSets> end{};
    for (int i = 0; i < kBlockVoxels; ++i) {
      const int x = i & 7, y = i >> 3 & 7, z = i >> 6;
      const int set = z | ((x + y) & 1) << 3;
      const int set_used = set & (num_sets_ - 1);
      const Eigen::Vector3f local(static_cast<float>(x), static_cast<float>(y),
                                  static_cast<float>(z));
      voxels_[set_used * per_set_ + end[set_used]++] = {R_B_A * local, i};
    }
  }

  /// Those of one block: neighbours have different ones.
  [[nodiscard]] const Voxel* begin(const BlockCoord& block) const {
    return &voxels_[((block.x() + 3 * block.y() + 5 * block.z()) & (num_sets_ - 1)) * per_set_];
  }
  [[nodiscard]] int per_block() const { return per_set_; }
  /// How many voxels one stands for.
  [[nodiscard]] int weight() const { return num_sets_; }

 private:
  static constexpr int kSets = 16;

  int num_sets_, per_set_;
  std::array<Voxel, kBlockVoxels> voxels_;
};

/// A known voxel of a coarse node that stands for all of them; neighbours have different ones.
int sampled_voxel(const BlockCoord& block, OctantMask known) {
  const int index = (73 * block.x() + 185 * block.y() + 329 * block.z()) & (kBlockVoxels - 1);
  if ((known >> octant_of(index) & 1) != 0) return index;
  const VoxelCoord corner = octant_corner(std::countr_zero(known));
  return index_in_block(corner.x() + (index & 3), corner.y() + (index >> 3 & 3),
                        corner.z() + (index >> 6 & 3));
}

/// Known voxels, by those of some blocks: of large volumes one in eight is enough.
std::int64_t estimate_known(const VoxelStore& store, const Volume& volume,
                            const SampledVoxels& sampled, bool is_sparse) {
  const int skipped = is_sparse ? 7 : 0;
  std::int64_t known = 0, known_samples = 0;
  volume.for_each_block(store, [&](const BlockCoord& block, const BlockView& view) {
    if (view.block == nullptr) {
      known += count_known(view);
      return;
    }
    if (((block.x() + 2 * block.y() + 3 * block.z()) & skipped) != 0) return;
    const SampledVoxels::Voxel* voxel = sampled.begin(block);
    for (const auto* end = voxel + sampled.per_block(); voxel != end; ++voxel) {
      known_samples += view.block->voxels[voxel->index] != kUnknownLogOdds;
    }
  });
  return known + known_samples * sampled.weight() * (skipped + 1);
}

bool agree(LogOdds a, LogOdds b) { return b != kUnknownLogOdds && (a > 0) == (b > 0); }

}  // namespace

std::int64_t count_known(const BlockView& view) {
  if (view.block == nullptr) return std::popcount(view.known) * kOctantVoxels;
  int known = 0;
  // Layer by layer, each in a byte: as many at a time as the widest vector holds.
  for (int layer = 0; layer < kBlockEdge; ++layer) {
    std::uint8_t known_in_layer = 0;
    const LogOdds* voxels = view.block->voxels + layer * (kBlockVoxels / kBlockEdge);
    for (int i = 0; i < kBlockVoxels / kBlockEdge; ++i)
      known_in_layer = static_cast<std::uint8_t>(known_in_layer + (voxels[i] != kUnknownLogOdds));
    known += known_in_layer;
  }
  return known;
}

std::int64_t count_known(const VoxelStore& store, const Volume& volume) {
  std::int64_t known = 0;
  volume.for_each_block(
      store, [&](const BlockCoord&, const BlockView& view) { known += count_known(view); });
  return known;
}

Eigen::AlignedBox3d known_bounds(const VoxelStore& store, const Volume& volume,
                                 double voxel_size_m) {
  Eigen::AlignedBox3i blocks;
  volume.for_each_block(store, [&](const BlockCoord& coord, const BlockView& view) {
    if (count_known(view) > 0) blocks.extend(coord);
  });
  if (blocks.isEmpty()) return {};
  const double edge_m = voxel_size_m * kBlockEdge;
  return {blocks.min().cast<double>() * edge_m,
          (blocks.max() + BlockCoord::Ones()).cast<double>() * edge_m};
}

VoxelOverlap voxel_overlap(const VoxelStore& store, const Volume& a, const Volume& b,
                           const Pose& T_b_a, double voxel_size_m) {
  VoxelOverlap overlap;
  const bool is_sparse = std::max(a.num_blocks(), b.num_blocks()) > kMaxDenseBlocks;
  const Eigen::Matrix3f R_b_a = T_b_a.linear().cast<float>();
  const SampledVoxels sampled(R_b_a, is_sparse);
  overlap.num_known_b = estimate_known(store, b, sampled, is_sparse);
  ChunkSampler under(store, b, T_b_a, voxel_size_m);
  for (PoolIndex at = a.first_chunk(); at != kNoIndex; at = store.chunk(at).next_in_volume) {
    const Chunk& chunk = store.chunk(at);
    const bool is_known = under.enter({chunk.x, chunk.y, chunk.z});
    for (int i = 0; i < kChunkBlocks; ++i) {
      if (chunk.places[i] == 0) continue;
      const VoxelCoord in_chunk(i & 7, i >> 3 & 7, i >> 6);
      const BlockCoord block = ChunkCoord(chunk.x, chunk.y, chunk.z) * kChunkEdge + in_chunk;
      const Eigen::Vector3f first = under.first() + R_b_a * (in_chunk * kBlockEdge).cast<float>();
      const BlockView view = Volume::view_of(store, chunk.places[i]);
      if (is_sparse && view.block == nullptr) {
        const std::int64_t known = count_known(view);
        overlap.num_known_a += known;
        const int index = sampled_voxel(block, view.known);
        const VoxelCoord local(index & 7, index >> 3 & 7, index >> 6);
        if (is_known && agree(view.coarse, under.at(first + R_b_a * local.cast<float>())))
          overlap.num_agreeing += known;
        continue;
      }
      int known = 0, agreeing = 0;
      const SampledVoxels::Voxel* voxel = sampled.begin(block);
      for (const auto* end = voxel + sampled.per_block(); voxel != end; ++voxel) {
        const LogOdds value = view.at(voxel->index);
        if (value == kUnknownLogOdds) continue;
        ++known;
        if (is_known) agreeing += agree(value, under.at(first + voxel->offset));
      }
      overlap.num_known_a += known * sampled.weight();
      overlap.num_agreeing += agreeing * sampled.weight();
    }
  }
  return overlap;
}

}  // namespace cloister
