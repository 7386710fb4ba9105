#pragma once

#include "mapping/core/pose.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// Where two volumes of one place lie against each other, once by the graph and once by their surfaces.
struct SurfaceAlignment {
  Pose T_b_a = Pose::Identity();  ///< what the surfaces say, or the graph's word where they have nothing to add
  double shift_m = 0;             ///< how far that is from the graph's word: the shift of the middle of their common
                                  ///< surfaces, and the turn at kLeverM; 0 for the graph's word itself
};

/// A graph knows two submaps against each other to a decimetre or two, and a fusion makes one wall of two only where they
/// meet within a voxel. So before that the surfaces of a are laid on those of b: each block whose surface, the faces between
/// its occupied voxels and free ones, lies in one plane is held against the nearest such plane of the other, and the pose
/// that brings the planes together (point to plane: Chen and Medioni 1992; weights of Geman and McClure) is looked for
/// around the graph's word. That word counts as one more measurement, of `sigma_m`, and a translation or turn that no
/// surface tells stays as it was.
///
/// The pose is taken only if the surfaces then agree clearly better, lies within twice `sigma_m`, and the graph's word was
/// off by more than a tenth of a voxel. Planes of voxels tell hardly more; errors that are let be add up over fusions.
///
/// @param T_b_a  the graph's word: pose of a's frame in b's
/// Threads: none may change the volumes meanwhile. Allocates. The same volumes give the same pose.
[[nodiscard]] SurfaceAlignment align_surfaces(const VoxelStore& store, const Volume& a,
                                              const Volume& b, const Pose& T_b_a, double sigma_m,
                                              double voxel_size_m);

}  // namespace cloister
