#pragma once

#include <cstddef>
#include <optional>

#include "mapping/core/config.hpp"
#include "mapping/submap/submap.hpp"

namespace cloister {

/// How far it can be trusted that two submaps lie where the graph has them.
enum class SharingTrust {
  kFull,          ///< what one gives away may stay with the other for ever
  kUncertain,     ///< the graph does not know well: only copies go, nothing is given
  kContradicted,  ///< the graph is sure, and what they see differs: one of two views goes
};

/// Leaves every place that two submaps know to the one whose sensor came nearer to it.
///
/// Submaps look into each other through doors and across squares, so each holds a worse copy of its neighbours: memory
/// would follow the number of submaps times what a sensor sees, and surfaces would be drawn once by each. A block of one
/// is given to the other when the other's trail (SubmapPath) comes nearer to its middle, and the other knows at least
/// half as many voxels there and sees the same surface to three voxels: a graph that is sure of a wrong pose would else
/// have places given away that cannot follow when it is corrected. What is given fills in what the other does not know;
/// where both know a voxel the nearer one's word stands: adding a view through a door to what was seen from within blurs
/// walls and wears them down. Where the two see a surface more than a voxel apart, filling in would put the further view
/// behind the nearer one's wall and draw it twice: if the nearer one knows most of the block, the further view is dropped.
///
/// Two submaps that may yet move against each other can still do without copies. Without full trust the further view is
/// dropped where the nearer one knows most of the block and shows its surface. What that one holds there is its own, and
/// moves with it.
///
/// A glimpse of what the nearer one has looked at closely goes without trust of any kind: far away, a block holds a few
/// returns, and where the nearer one knows half as much again of the place, little is lost if it stands elsewhere. Where
/// the graph is sure of both, and only what they see differs, it is enough that the nearer one knows as much: else each
/// visit would leave walls of its own, a little aside.
///
/// With full trust what is left of a few places in a chunk goes wherever it lies, if the other shows it and has more of the
/// chunk: its index takes four times what a place does. And a wall of which the other shows nothing goes along with the free
/// space before it, as a copy: neither is a surface without the other.
///
/// Where the places of two grids meet that are turned against each other, both keep blocks that hold little more than an
/// edge of the same wall. With full trust such a sliver goes, first of a and then of b, if the other shows it from the same
/// side; the free space before it stays. A sliver in whose octant all else is free stays: coarse, it would be free as well.
///
/// Since nearness decides of all else, and not which of the two asks, a second call finds little more to give unless one of the
/// submaps has changed.
/// @param T_a_b  pose of b's frame in a's: how far it can be trusted is for the caller to ask
/// @return number of blocks that changed hands or lost a sliver; nothing when the pools were too small, and whatever could not be given
///         is where it was
/// Threads: one owner of both submaps and the pools. Allocates lists of the blocks concerned.
[[nodiscard]] std::optional<std::size_t> share_places(Submap& a, Submap& b, const Pose& T_a_b,
                                                      const VoxelConfig& config, VoxelPools& pools,
                                                      SharingTrust trust = SharingTrust::kFull);

}  // namespace cloister
