#include "mapping/fuse/elastic_map.hpp"

#include <algorithm>
#include <new>

#include "mapping/fuse/fuser.hpp"
#include "mapping/fuse/fusion_leftovers.hpp"
#include "mapping/fuse/place_sharing.hpp"
#include "mapping/fuse/same_surface.hpp"
#include "mapping/fuse/shared_sight.hpp"
#include "mapping/overlap/convex_overlap.hpp"
#include "mapping/overlap/oriented_box.hpp"

namespace cloister {
namespace {

/// A comparison stands as long as the pair has moved less than half a voxel against each other anywhere in reach.
constexpr double kMaxMoveVox = 0.5;
/// What it shared stands for longer: surfaces within two voxels are the same.
constexpr double kMaxMoveSharedVox = 2;
/// Of two submaps of one place, the least share of surfaces that both show. Where the graph is right to 0.2 m nine rooms in
/// ten show 0.93 of them alike, and outdoors seven pairs in ten more than this; 0.36 m apart, nine rooms in ten show less.
constexpr double kMinSameSurface = 0.84;
/// How far surfaces may lie from the graph's word: what submaps themselves are off by, and what the graph owns of doubt.
constexpr double kMaxShiftM = 0.1;
constexpr double kMaxShiftSigmas = 3;
/// A remnant holds at most this share of what its submap knew, and the other at least this share of its sensor's places.
constexpr double kMaxShareOfRemnant = 0.1;
constexpr double kMinShareOfTrail = 0.4;
/// Blocks that lie on M's to a voxel, or nearly, are left where they are.
constexpr double kMinOffGridVox = 2;
/// Who walked no further aside than this walked the same way.
constexpr float kMaxBesideTrailM = 2;

/// True when no corner of a's bounds has moved as far as that against b.
bool has_stayed(const Pose& T_b_a_before, const Pose& T_b_a_now, const Eigen::AlignedBox3d& bounds_a,
                double max_move_m) {
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = bounds_a.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if ((T_b_a_before * p - T_b_a_now * p).norm() >= max_move_m) return false;
  }
  return true;
}

/// True when a submap knows the place at a point of its frame.
bool knows(const VoxelStore& store, const Submap& submap, const Eigen::Vector3f& p_S, double voxel_size_m) {
  const Eigen::Vector3f p_vox = p_S / static_cast<float>(voxel_size_m);
  return submap.volume.at(store, p_vox.array().floor().matrix().cast<int>()) != kUnknownLogOdds;
}

/// Of the places where a submap's sensor was, the share that another one knows.
double share_of_trail_known(const VoxelStore& store, const Submap& submap, const Submap& other,
                            double voxel_size_m) {
  const Eigen::Isometry3f T_other_S = (other.T_M_S.inverse() * submap.T_M_S).cast<float>();
  const auto points = submap.path.points();
  const auto num_known = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3f& p_S) {
    return knows(store, other, T_other_S * p_S, voxel_size_m);
  });
  return points.empty() ? 0 : static_cast<double>(num_known) / static_cast<double>(points.size());
}

double larger_ratio(const VoxelOverlap& overlap) {
  return std::max(overlap.ratio_a(), overlap.ratio_b());
}

}  // namespace

ElasticMap::ElasticMap(const Config& config, VoxelStore& store)
    : config_(config), store_(store), pools_(store) {}

void ElasticMap::refresh(Entry& entry) {
  entry.bounds_S = known_bounds(store_, entry.submap->volume, config_.voxel.voxel_size_m);
}

void ElasticMap::give_back_leftovers(Entry& entry) {
  try {
    if (!config_.baseline) {
      (void)forget_wall_interiors(pools_, entry.submap->volume);
      (void)settle_free_space(pools_, entry.submap->volume);
    }
  } catch (const std::bad_alloc&) {
    // The map is whole without, and they are looked for again after the next fusion.
  }
  refresh(entry);
}

void ElasticMap::add(Submap* submap) {
  if (revision_ != nullptr) apply_graph(*submap, *revision_);
  Entry& entry = entries_[submap->id];
  entry.submap = submap;
  unfinished_ = submap->is_continued ? submap->id : kNoSubmap;
  ++entry.num_sources;
  entry.num_known_whole = submap->volume.num_known(store_);
  refresh(entry);
  note_nodes(*submap);
}

void ElasticMap::note_nodes(const Submap& submap) {
  if (submap.root != kNoNode) root_at_spawn_.emplace(submap.id, submap.root);
  if (submap.first_node == kNoNode) return;
  // A node's scans can straddle two submaps: the first one was there when the node was made.
  node_owner_.emplace(submap.first_node, submap.id);
  node_owner_.emplace(submap.last_node, submap.id);
  if (revision_ == nullptr) return;
  // Ids may be sparse: only those of the graph are walked.
  const auto& nodes = revision_->graph.nodes;
  auto node = std::lower_bound(nodes.begin(), nodes.end(), submap.first_node,
                               [](const GraphNode& a, NodeId id) { return a.id < id; });
  for (; node != nodes.end() && node->id <= submap.last_node; ++node)
    node_owner_.emplace(node->id, submap.id);
}

int ElasticMap::set_graph(const GraphRevision* revision) {
  revision_ = revision;
  uncertainty_.reset();
  uncertainty_failed_ = false;
  int num_lost = 0;
  for (auto& [id, entry] : entries_) {
    const bool was_bound = entry.submap->root != kNoNode;
    num_lost += !apply_graph(*entry.submap, *revision);
    if (!was_bound) note_nodes(*entry.submap);
  }
  note_loops(*revision);
  return num_lost;
}

void ElasticMap::note_loops(const GraphRevision& revision) {
  for (const std::size_t i : revision.new_loops) {
    const GraphEdge& edge = revision.graph.edges[i];
    loops_.emplace_back(std::minmax(edge.from, edge.to));
  }
  if (revision.new_loops.empty()) return;
  // A loop closure changes the uncertainty of every pair: what was refused may be asked again.
  for (auto& [pair, comparison] : comparisons_) comparison.is_judged = false;
}

SubmapId ElasticMap::survivor(SubmapId id) const {
  for (auto it = fused_into_.find(id); it != fused_into_.end(); it = fused_into_.find(id))
    id = it->second;
  return id;
}

bool ElasticMap::joined_by_loop(SubmapId a, SubmapId b) const {
  return std::any_of(loops_.begin(), loops_.end(), [&](const auto& loop) {
    const SubmapId older = owner(loop.first);
    const SubmapId newer = owner(loop.second);
    return (older == a && newer == b) || (older == b && newer == a);
  });
}

bool ElasticMap::overlaps_enough(const PairCheck& checked) const {
  const auto comparison = comparisons_.find({checked.a->id, checked.b->id});
  return comparison != comparisons_.end() && is_one_place(comparison->second);
}

bool ElasticMap::goes_on(const Submap& a, const Submap& b) const {
  const auto is_from = [&](const Submap& later, const Submap& earlier) {
    return later.continues != kNoSubmap && survivor(later.continues) == earlier.id;
  };
  return !config_.baseline && (is_from(a, b) || is_from(b, a));
}

bool ElasticMap::is_one_place(const Comparison& comparison) const {
  return config_.baseline || comparison.goes_on ||
         (larger_ratio(comparison.overlap) >= config_.fusion.min_overlap &&
          comparison.sight >= config_.fusion.min_shared_sight);
}

const Submap* ElasticMap::find(SubmapId id) const {
  const auto it = entries_.find(id);
  return it != entries_.end() ? it->second.submap : nullptr;
}

SubmapId ElasticMap::owner(NodeId node) const {
  const auto it = node_owner_.find(node);
  return it != node_owner_.end() ? survivor(it->second) : kNoSubmap;
}

bool ElasticMap::covered_by_loop(NodeId root_a, NodeId root_b) const {
  const auto [older_root, newer_root] = std::minmax(root_a, root_b);
  return std::any_of(
      loops_.begin(), loops_.end(), [&, older = older_root, newer = newer_root](const auto& loop) {
        // The range begins with the submap that holds the loop's older end, so with that submap's root.
        const auto owner = node_owner_.find(loop.first);
        const auto root =
            owner == node_owner_.end() ? root_at_spawn_.end() : root_at_spawn_.find(owner->second);
        const NodeId begin =
            root == root_at_spawn_.end() ? loop.first : std::min(loop.first, root->second);
        return begin <= older && newer <= loop.second;
      });
}

bool ElasticMap::may_overlap_enough(const Entry& a, const Entry& b) const {
  if (a.bounds_S.isEmpty() || b.bounds_S.isEmpty()) return false;
  const OrientedBox box_a = oriented_box(a.bounds_S, a.submap->T_M_S);
  const OrientedBox box_b = oriented_box(b.bounds_S, b.submap->T_M_S);
  const auto [ratio_a, ratio_b] = aabb_overlap_ratios(bounds_in_map(box_a), bounds_in_map(box_b));
  return std::max(ratio_a, ratio_b) >= config_.fusion.min_overlap && !boxes_disjoint(box_a, box_b);
}

bool ElasticMap::is_current(const Comparison& comparison, const Entry& a, const Entry& b) const {
  const Pose T_b_a = b.submap->T_M_S.inverse() * a.submap->T_M_S;
  return comparison.sources_a == a.num_sources && comparison.sources_b == b.num_sources &&
         has_stayed(comparison.T_b_a, T_b_a, a.bounds_S,
                    kMaxMoveVox * config_.voxel.voxel_size_m);
}

std::vector<PairCheck> ElasticMap::plan_checks() {
  std::vector<PairCheck> checks;
  for (auto a = entries_.begin(); a != entries_.end(); ++a) {
    for (auto b = std::next(a); b != entries_.end(); ++b) {
      const auto known = comparisons_.find({a->first, b->first});
      if (known != comparisons_.end() && is_current(known->second, a->second, b->second)) continue;
      if (have_shared(a->first, b->first)) continue;
      const bool is_wanted = config_.baseline ? joined_by_loop(a->first, b->first)
                                              : may_overlap_enough(a->second, b->second) ||
                                                    goes_on(*a->second.submap, *b->second.submap);
      if (known != comparisons_.end()) comparisons_.erase(known);
      if (!is_wanted) continue;
      checks.push_back({a->second.submap,
                        b->second.submap,
                        b->second.submap->T_M_S.inverse() * a->second.submap->T_M_S,
                        {}});
    }
  }
  return checks;
}

void ElasticMap::record(const PairCheck& checked) {
  Comparison& comparison = comparisons_[{checked.a->id, checked.b->id}];
  comparison = {entries_.at(checked.a->id).num_sources, entries_.at(checked.b->id).num_sources,
                checked.T_b_a, checked.overlap};
  comparison.goes_on = goes_on(*checked.a, *checked.b);
  // Lines of sight cost more than a comparison of boxes: only of pairs that overlap enough.
  if (!config_.baseline && !comparison.goes_on &&
      larger_ratio(checked.overlap) >= config_.fusion.min_overlap)
    comparison.sight = shared_sight(store_, config_.voxel.voxel_size_m, *checked.a, *checked.b);
}

std::optional<FusionCandidate> ElasticMap::next_candidate() {
  const std::pair<const Pair, Comparison>* best = nullptr;
  double best_score = 0;
  for (const auto& item : comparisons_) {
    const auto& [pair, comparison] = item;
    const auto a = entries_.find(pair.first);
    const auto b = entries_.find(pair.second);
    if (!is_one_place(comparison) || comparison.is_judged || a == entries_.end() ||
        b == entries_.end())
      continue;
    if (!is_current(comparison, a->second, b->second)) continue;
    // In baseline mode lines of sight do not count, and all scores are zero. What goes on comes first: what becomes of it is
    // then held against other places as a whole.
    const double score =
        comparison.goes_on ? 2 : larger_ratio(comparison.overlap) * comparison.sight;
    if (best != nullptr && score <= best_score) continue;
    best = &item;
    best_score = score;
  }
  if (best == nullptr) return std::nullopt;
  const Pair pair = best->first;
  comparisons_[pair].is_judged = true;
  return FusionCandidate{pair.first, pair.second, joined_by_loop(pair.first, pair.second),
                         best->second.overlap, best->second.goes_on};
}

Judgement ElasticMap::judge(const FusionCandidate& candidate) {
  if (config_.baseline) return {true, std::nullopt, 0};
  const NodeId root_a = entries_.at(candidate.a).submap->root;
  const NodeId root_b = entries_.at(candidate.b).submap->root;
  Judgement judgement;
  judgement.limit_m = candidate.by_loop || covered_by_loop(root_a, root_b)
                          ? config_.fusion.max_sigma_m
                          : config_.fusion.max_sigma_unlooped_m;
  if (root_a != kNoNode && root_a == root_b) {
    judgement.sigma_m = {0, 0, 0};
  } else if (revision_ != nullptr && revision_->graph.edges.empty()) {
    judgement.is_uncertainty_unavailable = true;
    judgement.is_accepted = config_.fusion.fuse_without_covariance;
    return judgement;
  } else if (revision_ != nullptr && !uncertainty_failed_) {
    if (!uncertainty_) {
      auto built = RelativeUncertainty::build(revision_->graph);
      if (built) {
        uncertainty_ = std::move(*built);
      } else {
        uncertainty_failed_ = true;
      }
    }
    const auto sigma_m = uncertainty_ ? uncertainty_->larger_sigma_m(root_a, root_b) : std::nullopt;
    if (sigma_m) judgement.sigma_m = {(*sigma_m)[0], (*sigma_m)[1], (*sigma_m)[2]};
  }
  judgement.is_accepted = judgement.sigma_m && (*judgement.sigma_m)[2] <= judgement.limit_m;
  return judgement;
}

bool ElasticMap::is_certain(SubmapId a, SubmapId b) { return judge({a, b, joined_by_loop(a, b), {}}).is_accepted; }

bool ElasticMap::is_trusted(SubmapId a, SubmapId b) {
  const auto sharing = sharings_.find(std::minmax(a, b));
  return sharing != sharings_.end() && sharing->second.trust == SharingTrust::kFull && is_certain(a, b);
}

double ElasticMap::share_same_surfaces(const Submap& a, const Submap& b, const Pose& T_b_a) const {
  return compare_surfaces(store_, a.volume, b.volume, T_b_a, config_.voxel.voxel_size_m)
      .share_same();
}

std::optional<SurfaceAlignment> ElasticMap::agree(const FusionCandidate& candidate,
                                                  const Judgement& judgement) const {
  const Submap& a = *entries_.at(candidate.a).submap;
  const Submap& b = *entries_.at(candidate.b).submap;
  const Pose T_b_a = b.T_M_S.inverse() * a.T_M_S;
  if (config_.baseline) return SurfaceAlignment{T_b_a, 0};
  const SurfaceAlignment alignment = align_surfaces(store_, a.volume, b.volume, T_b_a,
                                                    config_.fusion.max_sigma_m, config_.voxel.voxel_size_m);
  if (judgement.sigma_m &&
      alignment.shift_m > kMaxShiftM + kMaxShiftSigmas * (*judgement.sigma_m)[2])
    return std::nullopt;
  if (share_same_surfaces(a, b, alignment.T_b_a) < kMinSameSurface) return std::nullopt;
  return alignment;
}

bool ElasticMap::have_shared(SubmapId a, SubmapId b) const {
  const auto sharing = sharings_.find({a, b});
  return sharing != sharings_.end() && sharing->second.refused_by_revision == 0 &&
         sharing->second.sources_a == entries_.at(a).num_sources &&
         sharing->second.sources_b == entries_.at(b).num_sources;
}

std::size_t ElasticMap::share_places() {
  if (config_.baseline) return 0;
  std::size_t moved = 0;
  const SubmapId unfinished = survivor(unfinished_);
  for (auto a = entries_.begin(); a != entries_.end(); ++a) {
    for (auto b = std::next(a); b != entries_.end(); ++b) {
      if (a->first == unfinished || b->first == unfinished) continue;
      moved += share_places(a->second, b->second, sharings_[{a->first, b->first}]);
    }
  }
  for (auto& [id, entry] : entries_) {
    if (!entry.has_shared) continue;
    entry.has_shared = false;
    give_back_leftovers(entry);
  }
  return moved;
}

std::size_t ElasticMap::share_places(Entry& a, Entry& b, Sharing& sharing) {
  const std::uint64_t revision = revision_ != nullptr ? revision_->revision : 0;
  const bool is_same = sharing.sources_a == a.num_sources && sharing.sources_b == b.num_sources;
  if (is_same && (sharing.refused_by_revision == 0 || sharing.refused_by_revision == revision))
    return 0;
  const Pose T_b_a = b.submap->T_M_S.inverse() * a.submap->T_M_S;
  const bool is_known =
      is_same && has_stayed(sharing.T_b_a, T_b_a, a.bounds_S,
                            kMaxMoveSharedVox * config_.voxel.voxel_size_m);
  const std::optional<SharingTrust> before = is_known ? sharing.trust : std::nullopt;
  sharing = {a.num_sources, b.num_sources, is_known ? sharing.T_b_a : T_b_a, before, 0};
  if (a.bounds_S.isEmpty() || b.bounds_S.isEmpty()) return 0;
  if (boxes_disjoint(oriented_box(a.bounds_S, a.submap->T_M_S),
                     oriented_box(b.bounds_S, b.submap->T_M_S)))
    return 0;
  const std::pair ids{a.submap->id, b.submap->id};
  if (!is_certain(ids.first, ids.second)) {
    sharing.trust = SharingTrust::kUncertain;
  } else if (before != SharingTrust::kContradicted) {
    sharing.trust = share_same_surfaces(*a.submap, *b.submap, T_b_a) >= kMinSameSurface
                        ? SharingTrust::kFull
                        : SharingTrust::kContradicted;
  }
  if (sharing.trust != SharingTrust::kFull) {
    sharing.refused_by_revision = revision;
    const auto comparison = comparisons_.find(ids);
    const bool may_fuse_later =
        comparison != comparisons_.end() && is_one_place(comparison->second);
    if (sharing.trust == before || may_fuse_later) return 0;
  }
  const auto moved = cloister::share_places(*a.submap, *b.submap, T_b_a.inverse(), config_.voxel,
                                            pools_, *sharing.trust);
  if (!moved || *moved == 0) return 0;
  a.has_shared = b.has_shared = true;
  refresh(a);
  refresh(b);
  return *moved;
}

SubmapId ElasticMap::find_heir(const Entry& remnant) {
  const SubmapId id = remnant.submap->id;
  SubmapId heir = kNoSubmap;
  double best_share = 0;
  for (const auto& [other, entry] : entries_) {
    const Pair pair = std::minmax(id, other);
    if (!have_shared(pair.first, pair.second)) continue;
    const double share = share_of_trail_known(store_, *remnant.submap, *entry.submap,
                                              config_.voxel.voxel_size_m);
    if (share < kMinShareOfTrail || share <= best_share) continue;
    if (!is_trusted(id, other)) continue;
    heir = other;
    best_share = share;
  }
  return heir;
}

std::optional<FusionCandidate> ElasticMap::find_remnant() {
  if (config_.baseline) return std::nullopt;
  const SubmapId unfinished = survivor(unfinished_);
  for (const auto& [id, entry] : entries_) {
    const double num_known = static_cast<double>(entry.submap->volume.num_known(store_));
    if (id == unfinished || num_known > kMaxShareOfRemnant * static_cast<double>(entry.num_known_whole)) continue;
    const SubmapId heir = find_heir(entry);
    if (heir == kNoSubmap) continue;
    const Submap& other = *entries_.at(heir).submap;
    return FusionCandidate{heir, id, joined_by_loop(heir, id),
                           voxel_overlap(store_, other.volume, entry.submap->volume,
                                         entry.submap->T_M_S.inverse() * other.T_M_S, config_.voxel.voxel_size_m)};
  }
  return std::nullopt;
}

Submap* ElasticMap::absorb(const FusionCandidate& remnant) {
  Entry& heir = entries_.at(remnant.a);
  const Submap& from = *entries_.at(remnant.b).submap;
  if (!fuse_volume(from.volume, from.T_M_S.inverse() * heir.submap->T_M_S, config_.voxel, pools_,
                   heir.submap->volume, BothKnown::kKeep))
    return nullptr;
  // What went on from it does not go on from its heir.
  for (auto& [id, entry] : entries_) {
    SubmapId& continues = entry.submap->continues;
    if (continues != kNoSubmap && survivor(continues) == remnant.b) continues = kNoSubmap;
  }
  return empty_into(heir, remnant.b);
}

Submap* ElasticMap::fuse(const FusionCandidate& candidate, const Pose& T_b_a) {
  Entry& a = entries_.at(candidate.a);
  const Submap& b = *entries_.at(candidate.b).submap;
  const std::vector<const Submap*> neighbours = find_neighbours(candidate.a);
  if (!fuse_volume(b.volume, T_b_a, config_.voxel, pools_, a.submap->volume)) return nullptr;
  a.submap->anchors.add(b.anchors, T_b_a);
  add_trail(*a.submap, b, T_b_a.inverse(), neighbours);
  // Both kinds of nodes have a say in where it lies now.
  if (revision_ != nullptr) apply_graph(*a.submap, *revision_);
  ++a.num_sources;
  lay_on_grid(*a.submap);
  Submap* emptied = empty_into(a, candidate.b);
  a.num_known_whole = a.submap->volume.num_known(store_);
  return emptied;
}

std::vector<const Submap*> ElasticMap::find_neighbours(SubmapId of) {
  std::vector<const Submap*> neighbours;
  for (const auto& [id, entry] : entries_) {
    if (id == of) continue;
    const auto comparison = comparisons_.find(std::minmax(id, of));
    if (comparison != comparisons_.end() && is_one_place(comparison->second)) continue;
    if (is_trusted(id, of)) neighbours.push_back(entry.submap);
  }
  return neighbours;
}

void ElasticMap::add_trail(Submap& into, const Submap& from, const Pose& T_into_from,
                           const std::vector<const Submap*>& neighbours) const {
  const auto points = from.path.points();
  const Eigen::Isometry3f T = T_into_from.cast<float>();
  std::array<bool, SubmapPath::kCapacity> is_of_neighbour{};
  for (const Submap* neighbour : neighbours) {
    if (neighbour == &from) continue;
    const Eigen::Isometry3f T_neighbour_into = (neighbour->T_M_S.inverse() * into.T_M_S).cast<float>();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f p_into = T * points[i];
      const Eigen::Vector3f p = T_neighbour_into * p_into;
      const float nearer_than_m2 = std::min(into.path.squared_distance(p_into), kMaxBesideTrailM * kMaxBesideTrailM);
      is_of_neighbour[i] |= neighbour->path.squared_distance(p) < nearer_than_m2 &&
                            knows(store_, *neighbour, p, config_.voxel.voxel_size_m);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_of_neighbour[i]) into.path.add(T * points[i]);
  }
}

void ElasticMap::lay_on_grid(Submap& submap) {
  if (config_.baseline) return;
  const double voxel_m = config_.voxel.voxel_size_m;
  const double block_m = voxel_m * kBlockEdge;
  const Eigen::Vector3d middle_S = known_bounds(store_, submap.volume, voxel_m).center();
  const Eigen::Vector3d corner_M = submap.T_M_S * ((middle_S / block_m).array().round().matrix() * block_m);
  const Eigen::Vector3d off_M = corner_M - (corner_M / block_m).array().round().matrix() * block_m;
  const Eigen::Vector3d off_vox = (submap.T_M_S.linear().transpose() * off_M / voxel_m).array().round();
  if (!(off_vox.cwiseAbs().maxCoeff() >= kMinOffGridVox)) return;
  Pose T_S_laid = Pose::Identity();
  T_S_laid.translation() = -voxel_m * off_vox;
  Volume laid;
  try {
    if (!fuse_volume(submap.volume, T_S_laid, config_.voxel, pools_, laid)) return;
  } catch (const std::bad_alloc&) {
    return;  // before anything was written: it stays where it is
  }
  submap.volume.swap(laid);
  laid.clear(pools_);
  submap.move_frame(T_S_laid);
}

Submap* ElasticMap::empty_into(Entry& into, SubmapId from_id) {
  give_back_leftovers(into);
  const auto entry = entries_.find(from_id);
  Submap* from = entry->second.submap;
  std::vector<SubmapId>& merged = into.submap->merged_from;
  merged.push_back(from_id);
  merged.insert(merged.end(), from->merged_from.begin(), from->merged_from.end());
  std::sort(merged.begin(), merged.end());
  into.submap->note_node(from->first_node);
  into.submap->note_node(from->last_node);
  from->volume.clear(pools_);
  from->reset();
  entries_.erase(entry);
  fused_into_[from_id] = into.submap->id;
  const auto is_of_from = [&](const auto& item) {
    return item.first.first == from_id || item.first.second == from_id;
  };
  std::erase_if(comparisons_, is_of_from);
  std::erase_if(sharings_, is_of_from);
  return from;
}

std::int64_t ElasticMap::bytes() const {
  std::size_t sum = 0;
  for (const auto& [id, entry] : entries_)
    sum += entry.submap->volume.bytes();
  return static_cast<std::int64_t>(sum);
}

std::vector<const Submap*> ElasticMap::submaps() const {
  std::vector<const Submap*> all;
  for (const auto& [id, entry] : entries_) {
    all.push_back(entry.submap);
  }
  return all;
}

}  // namespace cloister
