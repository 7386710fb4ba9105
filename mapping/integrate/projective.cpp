#include "mapping/integrate/projective.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "mapping/integrate/shared_scan.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrate/projective.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "mapping/integrate/block_update-inl.hpp"
#include "mapping/integrate/voxel_look-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kRootEdge = 512;  // voxels
constexpr int kChunkVoxels = kBlockEdge * kChunkEdge;
// Blocks nearer than this are looked up octant by octant: across them the projection bends too much.
constexpr float kMinFarVoxels = 200;
// Nearer than this, not even where an octant's middle is seen can be told from the block's own view.
constexpr float kMinLookVoxels = 40;

// Chunks are asked for free space by every scan, every other, or every third. A fourth turn would leave what has gone
// for more than a second.
constexpr int kMaxTurns = 3;
// Blocks rest where that does not make it more than four.
constexpr int kMaxRestTurns = 2;
static_assert(kMaxTurns <= 2 * kMaxRestTurns, "evidence is kept for that many turns");

class Carver {
 public:
  explicit Carver(const ProjectiveJob& job)
      : projector_(job.image, static_cast<float>(job.voxel_size_m),
                   static_cast<float>(job.max_range_m)),
        scan_number_(job.scan_number),
        bare_turns_(job.bare_turns),
        marks_(job.marks),
        pools_(job.pools),
        volume_(job.volume),
        reach_m_(static_cast<float>(job.max_range_m) + job.image.moved_m),
        sparse_m_(projector_.voxel_m * projector_.projection.max_rows_per_rad),
        evidence_for_{job.evidence, job.evidence, job.evidence, job.evidence} {
    for (int turns = 1; turns <= 2 * kMaxRestTurns; ++turns) {
      evidence_for_[turns - 1].miss =
          static_cast<LogOdds>(std::max(job.evidence.miss * turns, -127));
    }
  }

  ProjectiveResult run(SharedScan* shared) {
    shared_ = shared;
    const NodePose from = projector_.first_pose();
    VoxelCoord low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = static_cast<int>(std::floor((from.pose->t_S[a] - reach_m_) / projector_.voxel_m)) &
               ~(kRootEdge - 1);
      high[a] = static_cast<int>(std::floor((from.pose->t_S[a] + reach_m_) / projector_.voxel_m));
    }
    for (int z = low.z(); z <= high.z(); z += kRootEdge) {
      for (int y = low.y(); y <= high.y(); y += kRootEdge) {
        for (int x = low.x(); x <= high.x(); x += kRootEdge) divide({x, y, z}, kRootEdge, from);
      }
    }
    if (shared_ != nullptr) ask_chunks();
    return result_;
  }

  /// Finds out what becomes of a worker's chunks, as far as there is room to note it, and leaves it to be done by another.
  /// Several at once, on one volume.
  void decide(const std::vector<ChunkTask>& chunks, std::size_t stride, ScanShare& share) {
    shared_ = nullptr;
    decisions_ = &share.decisions;
    result_ = {};
    for (; share.next < chunks.size() && share.decisions.takes_chunk(); share.next += stride) {
      ask_chunk(chunks[share.next]);
    }
    share.result = result_;
  }

 private:
  static VoxelCoord child_corner_of(const VoxelCoord& corner, int edge, int child) {
    const VoxelCoord octant = octant_corner(child);
    const int scale = edge / kOctantEdge;
    return {corner.x() + scale * octant.x(), corner.y() + scale * octant.y(),
            corner.z() + scale * octant.z()};
  }

  void divide(const VoxelCoord& corner, int edge, const NodePose& from) {
    const int child_edge = edge / 2;
    NodeViews views;
    projector_.view_children(corner, child_edge, from, views);
    result_.nodes_tested += 8;
    unsigned ask = views.free | views.mixed;
    if (edge <= kChunkVoxels) {
      for (unsigned rest = views.mixed; rest != 0; rest &= rest - 1) {
        const int child = std::countr_zero(rest);
        const VoxelCoord child_corner = child_corner_of(corner, child_edge, child);
        if (!may_change(child_corner, child_edge, asks_bare_ && (views.gaps >> child & 1) != 0)) {
          ask &= ~(1u << child);
        }
      }
    }
    if (child_edge == kBlockEdge) fetch_blocks(corner, ask);
    for (unsigned rest = ask; rest != 0; rest &= rest - 1) {
      const int child = std::countr_zero(rest);
      const VoxelCoord child_corner = child_corner_of(corner, child_edge, child);
      const bool is_free = (views.free >> child) & 1;
      if (child_edge == kBlockEdge) {
        visit_block({child_corner, is_free, &views, child, nullptr});
        continue;
      }
      const NodePose child_from = projector_.pose_for(views, child, child_edge);
      if (child_edge == kChunkVoxels) {
        visit_chunk({child_corner, child_from.pose, child_from.share, is_free});
      } else if (is_free) {
        visit_free(child_corner, child_edge, child_from);
      } else {
        divide(child_corner, child_edge, child_from);
      }
    }
  }

  void visit_chunk(const ChunkTask& chunk) {
    if (shared_ == nullptr) {
      ask_chunk(chunk);
      return;
    }
    if (shared_->chunks.size() == shared_->chunks.capacity()) ask_chunks();
    shared_->chunks.push_back(chunk);
  }

  void ask_chunk(const ChunkTask& chunk) {
    const NodePose from{chunk.pose, chunk.pose_share};
    if (!enter_chunk(chunk.corner, from)) return;
    if (chunk.is_free) {
      visit_free(chunk.corner, kChunkVoxels, from);
    } else {
      divide(chunk.corner, kChunkVoxels, from);
    }
  }

  /// Asks the chunks that have been put aside, together with the other workers, and does what they decided.
  void ask_chunks() {
    struct Round {
      const Carver& carver;
      SharedScan& shared;
    } round{*this, *shared_};
    const auto work = [](void* context, int worker) {
      const Round& mine = *static_cast<Round*>(context);
      Carver carver = mine.carver;
      carver.decide(mine.shared.chunks, mine.shared.shares.size(),
                    mine.shared.shares[static_cast<std::size_t>(worker)]);
    };
    const auto is_left = [&](const ScanShare& share) {
      return share.next < shared_->chunks.size();
    };
    std::vector<ScanShare>& shares = shared_->shares;
    // Neighbours go to different workers: where much is to be looked into, all of them look.
    for (std::size_t worker = 0; worker < shares.size(); ++worker) shares[worker].next = worker;
    while (std::any_of(shares.begin(), shares.end(), is_left)) {
      for (ScanShare& share : shares) share.decisions.clear();
      shared_->workers.run(work, &round);
      for (const ScanShare& share : shares) {
        result_ += share.result;
        for (const BlockDecision& decision : share.decisions.all()) apply(decision);
      }
    }
    shared_->chunks.clear();
  }

  /// Does what a worker has decided.
  void apply(const BlockDecision& decision) {
    if (chunk_ == nullptr || decision.chunk != chunk_coord_) {
      chunk_coord_ = decision.chunk;
      find_chunk();
    }
    turns_ = decision.turns;
    evidence_ = &evidence_for_[turns_ - 1];
    switch (decision.kind) {
      case BlockDecision::Kind::kOctants:
        update_node(decision.index, decision.octants);
        break;
      case BlockDecision::Kind::kFree:
        update_free(decision.index);
        break;
      case BlockDecision::Kind::kVoxels:
        update_voxels(decision.index, decision.free, decision.crossed, decision.marked);
        break;
    }
  }

  BlockDecision& decide(BlockDecision::Kind kind, int index) {
    BlockDecision& decision = decisions_->add();
    decision.chunk = chunk_coord_;
    decision.index = static_cast<std::uint16_t>(index);
    decision.turns = static_cast<std::uint8_t>(turns_);
    decision.kind = kind;
    return decision;
  }

  /// Is there anything in a node of the entered chunk that a scan could change which does not see through all of it? Not in
  /// free space that is as sure as it can be; without gaps, in no free or unknown space at all.
  /// @param has_gaps  which are to be looked into
  bool may_change(const VoxelCoord& corner, int edge, bool has_gaps) const {
    if (chunk_ == nullptr && slots_ == nullptr) return has_gaps;
    const int first = index_in_block(parent_coord(corner));
    const int blocks = edge / kBlockEdge;
    const std::uint32_t settled = Volume::coarse_place(evidence_->lowest, kAllOctants);
    for (int z = 0; z < blocks; ++z) {
      for (int y = 0; y < blocks; ++y) {
        const int row = first + index_in_block(0, y, z);
        for (int x = row; x < row + blocks; ++x) {
          if (slots_ != nullptr && slots_[x] != 0) return true;
          const std::uint32_t place = chunk_ != nullptr ? chunk_->places[x] : 0;
          if (has_gaps ? place != settled
                       : Volume::has_block(place) || Volume::coarse_value(place) > 0)
            return true;
        }
      }
    }
    return false;
  }

  /// Calls for the memory of children that will be visited: it arrives while the first of them are looked up.
  void fetch_blocks(const VoxelCoord& corner, unsigned children) const {
    if (chunk_ == nullptr) return;
    for (unsigned rest = children; rest != 0; rest &= rest - 1) {
      const BlockCoord block =
          parent_coord(child_corner_of(corner, kBlockEdge, std::countr_zero(rest)));
      const std::uint32_t place = chunk_->places[index_in_block(block)];
      if (!Volume::has_block(place)) continue;
      const LogOdds* voxels = pools_.store.block(Volume::block_index(place)).voxels;
      for (int i = 0; i < kBlockVoxels; i += 64) __builtin_prefetch(voxels + i);
    }
  }

  /// Whatever follows concerns the chunk with this corner, until another is entered.
  /// @return false when it is another scan's turn to ask it
  bool enter_chunk(const VoxelCoord& corner, const NodePose& from) {
    chunk_coord_ = parent_coord(parent_coord(corner));
    turns_ = turns_of(corner, from);
    const std::int64_t turn = static_cast<std::int64_t>(scan_number_) + chunk_coord_.x() +
                              chunk_coord_.y() + chunk_coord_.z();
    if (turn % turns_ != 0) return false;
    turn_ = turn / turns_;
    asks_bare_ = turns_ == 1 || turn_ % bare_turns_ == 0;
    evidence_ = &evidence_for_[turns_ - 1];
    find_chunk();
    slots_ = marks_.find_chunk(chunk_coord_);
    return true;
  }

  void find_chunk() {
    const PoolIndex index = volume_.find_chunk(pools_.store, chunk_coord_);
    chunk_ = index == kNoIndex ? nullptr : &pools_.store.chunk(index);
  }

  /// How many scans take turns in asking a chunk. There may be no other than the first.
  int turns_of(const VoxelCoord& corner, const NodePose& from) const {
    if (scan_number_ == 0) return 1;
    constexpr float kHalf = 0.5f * kChunkVoxels;
    const float x = projector_.voxel_m * (static_cast<float>(corner.x()) + kHalf);
    const float y = projector_.voxel_m * (static_cast<float>(corner.y()) + kHalf);
    const float z = projector_.voxel_m * (static_cast<float>(corner.z()) + kHalf);
    const Eigen::Vector3f& sensor_S = from.pose->t_S;
    const float distance_m = std::hypot(x - sensor_S.x(), y - sensor_S.y(), z - sensor_S.z());
    return distance_m > 2 * sparse_m_ ? 3 : distance_m > sparse_m_ ? 2 : 1;
  }

  /// Resting blocks are looked up by every other scan of those that ask their chunk.
  bool rests(std::uint32_t place) const { return Volume::rests(place) && turns_ <= kMaxRestTurns; }
  bool is_turn_of(const VoxelCoord& block_corner) const {
    const BlockCoord block = parent_coord(block_corner);
    return ((turn_ + block.x() + block.y() + block.z()) & 1) == 0;
  }

  /// What a scan says at a place of the entered chunk counts for the scans that it stands for.
  const Evidence& evidence_at(std::uint32_t place) const {
    return rests(place) ? evidence_for_[2 * turns_ - 1] : *evidence_;
  }

  bool make_chunk() {
    if (chunk_ != nullptr) return true;
    if (volume_.make_place(pools_, chunk_coord_ * kChunkEdge, &chunk_) != nullptr) return true;
    chunk_ = nullptr;
    return false;
  }

  /// A node that is free throughout.
  void visit_free(const VoxelCoord& corner, int edge, const NodePose& from) {
    if (edge > kChunkVoxels) {
      for (int child = 0; child < 8; ++child) {
        const VoxelCoord child_corner = child_corner_of(corner, edge / 2, child);
        if (edge / 2 == kChunkVoxels) {
          visit_chunk({child_corner, from.pose, from.share, true});
        } else {
          visit_free(child_corner, edge / 2, from);
        }
      }
      return;
    }
    for (int z = 0; z < edge; z += kBlockEdge) {
      for (int y = 0; y < edge; y += kBlockEdge) {
        for (int x = 0; x < edge; x += kBlockEdge)
          visit_block({corner + VoxelCoord(x, y, z), true, nullptr, 0, &from});
      }
    }
  }

  /// A block on its way through a scan.
  struct BlockVisit {
    VoxelCoord corner;
    bool is_free;            ///< it is seen through as a whole
    const NodeViews* views;  ///< how it looks as one of eight; null in a larger node that is free
    int child;               ///< which of the eight
    const NodePose* from;    ///< where it is seen from, without views
  };

  /// Is a block, seen by one pose as a whole, this far away?
  bool is_beyond(const BlockVisit& visit, const NodePose& from, float voxels) const {
    return visit.views != nullptr && from.share < 1 &&
           visit.views->distance_m[visit.child] > voxels * projector_.voxel_m;
  }

  NodePose pose_for(const BlockVisit& visit) const {
    return visit.views != nullptr ? projector_.pose_for(*visit.views, visit.child, kBlockEdge)
                                  : *visit.from;
  }

  void visit_block(const BlockVisit& visit) {
    const int index = index_in_block(parent_coord(visit.corner));
    const std::uint32_t place = chunk_ != nullptr ? chunk_->places[index] : 0;
    if (rests(place) && !is_turn_of(visit.corner)) return;
    ScanMarks::Marked* marked =
        slots_ != nullptr && slots_[index] != 0 ? &marks_.in_slot(slots_[index]) : nullptr;
    if (marked == nullptr && !Volume::has_block(place) && Volume::coarse_value(place) <= 0) {
      if (visit.is_free) {
        ++result_.blocks_free;
        update_node(index, kAllOctants);
      } else if (asks_bare_ && (visit.views->gaps >> visit.child & 1) != 0 &&
                 Volume::known_octants(place) != kAllOctants) {
        ++result_.blocks_coarse;
        result_.blocks_in_turn += turns_ > 1;
        update_node(index, free_octants(visit, Volume::known_octants(place)));
      }
      return;
    }
    if (marked == nullptr && visit.is_free && Volume::has_block(place)) {
      if (highest_in(pools_.store.block(Volume::block_index(place))) <= 0) {
        ++result_.blocks_free;
        update_free(index);
        return;
      }
    }
    look_into(visit, index, marked);
  }

  /// What the octants of a block that is bare or coarse have shown: those that are seen through as wholes.
  void update_node(int index, OctantMask free) {
    if (free == kNoOctants) return;
    if (decisions_ != nullptr) {
      decide(BlockDecision::Kind::kOctants, index).octants = free;
      return;
    }
    if (!make_chunk()) {
      result_.voxels_declined += kBlockVoxels;
      return;
    }
    add_free_octants(*evidence_, free, std::popcount(free) * kOctantVoxels, pools_, volume_,
                     *chunk_, chunk_->places[index]);
  }

  /// A block with voxels of which none is occupied, and which is seen through as a whole.
  void update_free(int index) {
    if (decisions_ != nullptr) {
      (void)decide(BlockDecision::Kind::kFree, index);
      return;
    }
    std::uint32_t& place = chunk_->places[index];
    Block& block = pools_.store.block(Volume::block_index(place));
    const Changes changes = add_evidence(evidence_at(place), kAll, kAll, kNone, block);
    Volume::set_rest(place, changes.may_rest());
    volume_.settle_block(pools_, *chunk_, place);
  }

  /// A block that was looked up voxel by voxel.
  /// @param marked  its returns, or null
  void update_voxels(int index, const BlockBits& free, const BlockBits& crossed,
                     const ScanMarks::Marked* marked) {
    if (decisions_ != nullptr) {
      BlockDecision& decision = decide(BlockDecision::Kind::kVoxels, index);
      decision.free = free;
      decision.crossed = crossed;
      decision.marked = marked;
      return;
    }
    if (!make_chunk()) {
      result_.voxels_declined += kBlockVoxels;
      return;
    }
    std::uint32_t& place = chunk_->places[index];
    result_.voxels_declined +=
        apply_to_place(evidence_at(place), free, crossed, marked != nullptr ? marked->hit : kNone,
                       pools_, volume_, *chunk_, place);
  }

  /// Octants that are seen through as wholes, but for a few voxels at their borders.
  OctantMask free_octants(const BlockVisit& visit, OctantMask known) const {
    const NodePose from = pose_for(visit);
    unsigned candidates = kAllOctants;
    if (is_beyond(visit, from, kMinLookVoxels)) {
      // Most blocks that come here show nothing: one look at the middles of their octants tells.
      const VoxelLook look(projector_, LinearView(*visit.views, visit.child),
                           0.5f * (kBlockEdge - 1), false);
      candidates = look.at(kOctantMiddles, 0, kWhole).free & kAllOctants;
      if (candidates == kNoOctants) return kNoOctants;
      if (look.fits() && is_beyond(visit, from, kMinFarVoxels)) {
        unsigned free = 0;
        for (unsigned open = candidates; open != 0; open &= open - 1) {
          const int octant = std::countr_zero(open);
          free |= static_cast<unsigned>(
                      is_seen_through(look, kOctantSlices[octant & 3], octant < 4 ? -2 : 2))
                  << octant;
        }
        return static_cast<OctantMask>(free);
      }
    }
    NodeViews views;
    projector_.view_children(visit.corner, kOctantEdge, from, views);
    unsigned free = views.free;
    if (from.share < 1) {
      for (unsigned open = views.mixed & views.gaps & candidates & ~unsigned{known}; open != 0;
           open &= open - 1) {
        const int child = std::countr_zero(open);
        const VoxelLook look(projector_, LinearView(views, child), 0.5f * (kOctantEdge - 1), false);
        free |= static_cast<unsigned>(is_seen_through(look, kOctantSlice, 0)) << child;
      }
    } else if (free != kAllOctants) {
      BlockBits seen = kNone, crossed = kNone;
      look_up_at_seam(visit.corner, kNoOctants, seen, crossed);
      for (int octant = 0; octant < 8; ++octant) {
        const std::uint64_t* words = seen.word + octant_corner(octant).z();
        int num_seen = 0;
        for (int z = 0; z < kOctantEdge; ++z) {
          num_seen += std::popcount(words[z] & octant_rows(octant));
        }
        free |= static_cast<unsigned>(num_seen >= kOctantVoxels - kMaxUnseenVoxels) << octant;
      }
    }
    return static_cast<OctantMask>(free);
  }

  /// An octant of a coarse node counts as seen through when all of its voxels are, but for a few at its border.
  /// @param slice  its lowest voxels but for their z, from the look's middle @param z  of its middle
  static bool is_seen_through(const VoxelLook& look, const Offsets& slice, float z) {
    int num_unseen = 0;
    for (int i = 0; i < kOctantEdge && num_unseen <= kMaxUnseenVoxels; ++i) {
      num_unseen +=
          16 - std::popcount(look.at(slice, z + static_cast<float>(i) - 1.5f, kWhole).free);
    }
    return num_unseen <= kMaxUnseenVoxels;
  }

  /// A block with returns or with voxels of its own: decided voxel by voxel. If it is seen through as a whole, what
  /// remains to be found out is which voxels beams have crossed.
  void look_into(const BlockVisit& visit, int index, ScanMarks::Marked* marked) {
    ++result_.blocks_mixed;
    BlockBits free = visit.is_free ? kAll : kNone, crossed = kNone;
    const std::uint32_t place = chunk_ != nullptr ? chunk_->places[index] : 0;
    const unsigned occupied = Volume::has_block(place)
                                  ? occupied_octants(pools_.store.block(Volume::block_index(place)))
                              : Volume::coarse_value(place) > 0 ? kAllOctants
                                                                : kNoOctants;
    const NodePose from = pose_for(visit);
    if (from.share >= 1) {
      look_up_at_seam(visit.corner, occupied, free, crossed);
    } else if (!is_beyond(visit, from, kMinFarVoxels) ||
               !look_up_block(LinearView(*visit.views, visit.child), occupied != kNoOctants, free,
                              crossed)) {
      look_up_octants(visit.corner, {from.pose, 0}, kWhole, occupied, free, crossed);
    }
    const BlockBits& hit = marked != nullptr ? marked->hit : kNone;
    for (int z = 0; z < kBlockEdge; ++z) free.word[z] &= ~hit.word[z];
    if (marked != nullptr) marked->is_applied = true;
    if (marked != nullptr || free.any()) update_voxels(index, free, crossed, marked);
  }

  /// Looks up a block from its own view. @return false when it has too many pixels for that
  bool look_up_block(const LinearView& view, bool has_occupied, BlockBits& free,
                     BlockBits& crossed) const {
    const VoxelLook look(projector_, view, 0.5f * (kBlockEdge - 1), has_occupied);
    if (look.fits()) look.at_block(free, crossed);
    return look.fits();
  }

  /// Looks up a block where the scan's beginning and end meet: with both their poses.
  void look_up_at_seam(const VoxelCoord& corner, unsigned occupied, BlockBits& free,
                       BlockBits& crossed) const {
    const int columns = projector_.projection.num_columns;
    look_up_octants(corner, {&projector_.image.poses.front(), 0}, {0, columns / 2, true}, occupied,
                    free, crossed);
    look_up_octants(corner, {&projector_.image.poses.back(), 0}, {columns / 2, columns, true},
                    occupied, free, crossed);
  }

  /// Looks up a block octant by octant with one pose, as far as its columns belong to it.
  /// @param occupied  octants with occupied voxels
  void look_up_octants(const VoxelCoord& corner, const NodePose& from, const ColumnWindow& window,
                       unsigned occupied, BlockBits& free, BlockBits& crossed) const {
    NodeViews views;
    projector_.view_children(corner, kOctantEdge, from, views);
    // What is decided for octants is right for one pose only; where two meet, each voxel is asked. Elsewhere, only beams
    // that may see through something, or clear it, are of interest.
    const unsigned seen = window.is_seam ? 0 : views.free;
    const unsigned ask = window.is_seam
                             ? views.free | views.mixed
                             : (views.mixed & (views.gaps | occupied)) | (views.free & occupied);
    for (int child = 0; child < 8; ++child) {
      const VoxelCoord local = octant_corner(child);
      const int shift = local.x() + kBlockEdge * local.y();
      if ((seen >> child & 1) != 0) {
        for (int z = 0; z < kOctantEdge; ++z) free.word[local.z() + z] |= octant_rows(child);
      }
      if ((ask >> child & 1) == 0) continue;
      const VoxelLook look(projector_, LinearView(views, child), 0.5f * (kOctantEdge - 1),
                           (occupied >> child & 1) != 0);
      for (int z = 0; z < kOctantEdge; ++z) {
        const SliceBits bits = look.at(kOctantSlice, static_cast<float>(z) - 1.5f, window);
        free.word[local.z() + z] |= spread(bits.free) << shift;
        crossed.word[local.z() + z] |= spread(bits.crossed) << shift;
      }
    }
  }

  /// Four rows of four bits, as rows of eight.
  static std::uint64_t spread(std::uint64_t bits) {
    return (bits & 0xf) | ((bits & 0xf0) << 4) | ((bits & 0xf00) << 8) | ((bits & 0xf000) << 12);
  }

  static constexpr std::uint64_t kFull = ~std::uint64_t{0};
  static constexpr BlockBits kAll{{kFull, kFull, kFull, kFull, kFull, kFull, kFull, kFull}};
  static constexpr BlockBits kNone{};

  NodeProjector projector_;
  std::uint64_t scan_number_;
  int bare_turns_;
  ScanMarks& marks_;
  VoxelPools& pools_;
  Volume& volume_;
  float reach_m_;   ///< no beam ends further from where the sensor was in the middle of the scan
  float sparse_m_;  ///< from here on rows are more than a voxel apart
  Evidence evidence_for_[2 * kMaxRestTurns];  ///< by the number of scans that take turns, less one

  const Evidence* evidence_ = nullptr;  ///< for the chunk that was entered
  int turns_ = 1;                       ///< of scans that ask it
  std::int64_t turn_ = 0;               ///< counts the scans that do
  bool asks_bare_ = true;               ///< it is the turn of its bare blocks as well
  ChunkCoord chunk_coord_ = ChunkCoord::Zero();
  Chunk* chunk_ = nullptr;
  const ScanMarks::Slot* slots_ = nullptr;
  SharedScan* shared_ = nullptr;         ///< chunks are put aside for several threads
  BlockDecisions* decisions_ = nullptr;  ///< what is found out is left to be done by another
  ProjectiveResult result_;
};

ProjectiveResult integrate_projective_vectors(const ProjectiveJob& job) {
  return Carver(job).run(job.shared);
}

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cloister {

HWY_EXPORT(integrate_projective_vectors);

ProjectiveResult integrate_projective(const ProjectiveJob& job) {
  return HWY_DYNAMIC_DISPATCH(integrate_projective_vectors)(job);
}

}  // namespace cloister
#endif
