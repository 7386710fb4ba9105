#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "mapping/core/config.hpp"
#include "mapping/fuse/place_sharing.hpp"
#include "mapping/fuse/same_surface.hpp"
#include "mapping/fuse/surface_alignment.hpp"
#include "mapping/graph/graph_revision.hpp"
#include "mapping/graph/relative_uncertainty.hpp"
#include "mapping/overlap/voxel_overlap.hpp"
#include "mapping/submap/submap.hpp"

namespace cloister {

/// One exact comparison that the overlap worker is asked for, and its answer.
struct PairCheck {
  const Submap* a = nullptr;  ///< the one with the smaller id
  const Submap* b = nullptr;
  Pose T_b_a = Pose::Identity();
  VoxelOverlap overlap;  ///< filled by the worker
};

/// A pair that is to become one submap, if the graph is certain enough.
struct FusionCandidate {
  SubmapId a = kNoSubmap;  ///< it stays: the smaller id, or a remnant's heir
  SubmapId b = kNoSubmap;
  bool by_loop = false;  ///< a loop closure joins the two
  VoxelOverlap overlap;
  bool goes_on = false;  ///< the later one continues the other (Submap::continues), however little they overlap
};

/// The graph's word on a candidate.
struct Judgement {
  bool is_accepted = false;
  std::optional<std::array<double, 3>>
      sigma_m;  ///< translational standard deviations, ascending, metres
  double limit_m = 0;
  bool is_uncertainty_unavailable =
      false;  ///< the graph has no edges: FusionConfig::fuse_without_covariance decided
};

/// The finished submaps and what is to become of them: which pairs to compare, which to fuse (paper, section III-B
/// and III-C).
///
/// A pair is compared when both the axis-aligned boxes of what they know overlap enough and the oriented boxes touch,
/// and again only after one of them, or their relative pose, has changed. A pair that overlaps enough (FusionConfig
/// says how it tells one place seen twice from two rooms seen through a door), or of which one continues the other, is
/// fused when the standard deviation between their roots is within `max_sigma_m`, provided that a loop closure's range covers
/// both roots; without one, the graph must know their place to `max_sigma_unlooped_m`.
///
/// What has been shared says nothing about overlap any more, so of a short way through a place that others have walked
/// better only crumbs may be left, and a submap of its own for each time it is walked. Such a remnant, of a tenth of what it
/// knew, joins its heir: the submap that knows most of its sensor's way, at least two fifths, and with which it has shared in
/// full trust.
///
/// Threads: one owner (the fusion scheduler). Submaps are lent to the overlap worker between `plan_checks` and
/// `record`, and must not be fused meanwhile. Allocates. The same calls give the same result.
class ElasticMap {
 public:
  ElasticMap(const Config& config, VoxelStore& store);

  [[nodiscard]] VoxelPools& pools() { return pools_; }

  /// Takes over a finished submap.
  void add(Submap* submap);
  /// Moves all submaps to a new revision, and notes its loop closures. The revision must live until the next one.
  /// @return number of submaps whose root the revision does not have
  int set_graph(const GraphRevision* revision);

  /// Pairs that need an exact comparison now, by ascending ids. Call after every `add`, `set_graph` and fusion until
  /// nothing comes any more.
  [[nodiscard]] std::vector<PairCheck> plan_checks();
  void record(const PairCheck& checked);
  /// The pair to judge next, the one that shares most volume and sight, or nothing. Each pair comes once a comparison and,
  /// if refused, once a loop closure.
  [[nodiscard]] std::optional<FusionCandidate> next_candidate();
  [[nodiscard]] Judgement judge(const FusionCandidate& candidate);
  /// Where the two lie against each other by the graph and, around its word, by their surfaces (see align_surfaces).
  /// Nothing when the graph is wrong about them: when they see the surfaces of their place apart even so (see
  /// compare_surfaces), or, in the middle of what both show, further from its word than 0.1 m and three of its standard
  /// deviations. In baseline mode the graph's word, always.
  [[nodiscard]] std::optional<SurfaceAlignment> agree(const FusionCandidate& candidate,
                                                      const Judgement& judgement) const;
  /// Once there is nothing more to fuse: leaves each place that two submaps know to the one whose sensor came nearer to
  /// it (see share_places): with full trust where the graph is as certain of the pair as a fusion needs and both see the
  /// surfaces of their place alike, else only copies, glimpses and second views go, unless they wait to be fused. Pairs of
  /// which neither has taken up scans since are passed over, and so is what another submap will continue: only whole places
  /// can be told apart by their overlap, and what is shared counts no more.
  /// @return number of blocks that changed hands or lost a sliver
  [[nodiscard]] std::size_t share_places();
  /// Makes b part of a: a keeps its id, its slot and its frame, but for whole voxels by which its blocks are laid on M's
  /// anew. It takes over b's trail, but for where a neighbour with which it has shared in full trust knows the place and
  /// walked, within 2 m, nearer than a itself: a submap that was begun in one room and ended in the next overlaps both, and
  /// through its trail they would see each other and be taken for one.
  /// @param T_b_a  pose of a's frame in b's
  /// @return b's slot, emptied, or null (nothing changed) when the pools are too small
  [[nodiscard]] Submap* fuse(const FusionCandidate& candidate, const Pose& T_b_a);
  /// Once places are shared: a remnant as b, and its heir as a; or nothing. The graph is certain of the two. Their surfaces
  /// are not asked: what is left of a remnant is what differed.
  [[nodiscard]] std::optional<FusionCandidate> find_remnant();
  /// Makes a remnant part of its heir, which takes what it does not know and stays as it is otherwise. It has no say in
  /// where the heir lies, and what the heir was told of its neighbours still holds.
  /// @return as `fuse`
  [[nodiscard]] Submap* absorb(const FusionCandidate& remnant);

  /// True when the pair was recorded as one place seen twice.
  [[nodiscard]] bool overlaps_enough(const PairCheck& checked) const;
  /// A finished submap by its id, or null.
  [[nodiscard]] const Submap* find(SubmapId id) const;
  /// The submap that holds a node's scans now, or kNoSubmap.
  [[nodiscard]] SubmapId owner(NodeId node) const;
  /// The submap that an id has become by fusions so far.
  [[nodiscard]] SubmapId survivor(SubmapId id) const;
  /// True when a loop closure joins the two.
  [[nodiscard]] bool joined_by_loop(SubmapId a, SubmapId b) const;
  [[nodiscard]] std::vector<const Submap*> submaps() const;
  /// What the volumes of all finished submaps take.
  [[nodiscard]] std::int64_t bytes() const;

 private:
  struct Entry {
    Submap* submap = nullptr;
    std::uint32_t num_sources =
        0;  ///< grows when scans are added or fused into it, not when places are shared
    Eigen::AlignedBox3d bounds_S;  ///< of what it knows
    std::size_t num_known_whole = 0;  ///< places that it knew when scans were last added or fused into it
    bool has_shared = false;          ///< since its leftovers were last looked for
  };
  /// What is known about a pair, until one of both changes.
  struct Comparison {
    std::uint32_t sources_a = 0, sources_b = 0;
    Pose T_b_a = Pose::Identity();
    VoxelOverlap overlap;
    double sight = 0;  ///< see shared_sight
    bool goes_on = false;  ///< see FusionCandidate
    bool is_judged = false;
  };
  using Pair = std::pair<SubmapId, SubmapId>;
  /// When a pair was last asked to share: not again before new scans have come to one or, if it was
  /// refused, the graph has changed. What sharing itself changes does not count: blocks of two grids could change hands for ever.
  struct Sharing {
    std::uint32_t sources_a = 0, sources_b = 0;
    Pose T_b_a = Pose::Identity();
    std::optional<SharingTrust> trust;  ///< nothing while the two have not met
    std::uint64_t refused_by_revision = 0;
  };

  [[nodiscard]] bool may_overlap_enough(const Entry& a, const Entry& b) const;
  /// True when the pair was told apart and has shared what both knew: what is left of it says nothing about overlap.
  [[nodiscard]] bool have_shared(SubmapId a, SubmapId b) const;
  [[nodiscard]] std::size_t share_places(Entry& a, Entry& b, Sharing& sharing);
  [[nodiscard]] bool is_current(const Comparison& comparison, const Entry& a, const Entry& b) const;
  [[nodiscard]] bool is_one_place(const Comparison& comparison) const;
  /// True when one of the two was begun only because the other had become too long.
  [[nodiscard]] bool goes_on(const Submap& a, const Submap& b) const;
  /// True when the two have shared in full trust, and the graph has not changed its mind since.
  [[nodiscard]] bool is_trusted(SubmapId a, SubmapId b);
  /// The submaps that are trusted against one and are no part of its place.
  [[nodiscard]] std::vector<const Submap*> find_neighbours(SubmapId of);
  void add_trail(Submap& into, const Submap& from, const Pose& T_into_from,
                 const std::vector<const Submap*>& neighbours) const;
  /// Moves a submap's blocks by whole voxels, so that in its middle they lie on M's, if there is memory for it: corrections
  /// turn and shift grids against each other, and along the borders of those that differ walls are held twice.
  void lay_on_grid(Submap& submap);
  [[nodiscard]] SubmapId find_heir(const Entry& remnant);
  /// Ends a fusion: the submap `from_id`, which is part of `into` now, gives up its slot.
  Submap* empty_into(Entry& into, SubmapId from_id);
  [[nodiscard]] bool covered_by_loop(NodeId root_a, NodeId root_b) const;
  /// True when the graph is as certain of the pair as a fusion needs.
  [[nodiscard]] bool is_certain(SubmapId a, SubmapId b);
  [[nodiscard]] double share_same_surfaces(const Submap& a, const Submap& b, const Pose& T_b_a) const;
  void note_nodes(const Submap& submap);
  void note_loops(const GraphRevision& revision);
  void refresh(Entry& entry);
  /// After a fusion or sharing (see fusion_leftovers.hpp); in baseline mode there are none.
  void give_back_leftovers(Entry& entry);

  Config config_;
  VoxelStore& store_;
  VoxelPools pools_;
  const GraphRevision* revision_ = nullptr;
  std::optional<RelativeUncertainty> uncertainty_;  ///< of revision_, made when first needed
  bool uncertainty_failed_ = false;
  std::map<SubmapId, Entry> entries_;
  std::map<Pair, Comparison> comparisons_;
  std::map<Pair, Sharing> sharings_;
  std::map<SubmapId, SubmapId> fused_into_;
  SubmapId unfinished_ = kNoSubmap;  ///< the last one added, if another will continue it
  std::map<NodeId, SubmapId> node_owner_;  ///< the first submap that holds a node's scans
  std::map<SubmapId, NodeId> root_at_spawn_;
  std::vector<std::pair<NodeId, NodeId>> loops_;  ///< all loop closures so far, (older, newer)
};

}  // namespace cloister
