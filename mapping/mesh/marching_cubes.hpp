#pragma once

#include "mapping/mesh/triangle_mesh.hpp"
#include "mapping/voxel/volume.hpp"

namespace cloister {

/// The surface between free and occupied space, by marching cubes (Lorensen and Cline 1987) on the
/// zero crossing of the log-odds, over the lattice of voxel centres.
///
/// A cube with an unknown corner is skipped, so the surface is open where it runs into unknown
/// space. Elsewhere it is watertight, across blocks and chunks too: one vertex per crossed lattice
/// edge, two triangles per side (see cube_cases.hpp). Triangles are counter-clockwise seen from
/// free space.
///
/// The zero crossing lies between the last free voxel and the first occupied one, so before the surface that the
/// returns were measured on; `depth` draws it deeper. Of thousands of noisy returns some fall short into the voxel before
/// the surface, so where two voxels and more are occupied one behind the other, the surface lies between the first two.
///
/// @param voxel_size_m  edge of a voxel
/// @param depth  0 draws the zero crossing itself; towards 1, vertices move on to the occupied voxel's centre, or to
///               half a voxel behind it where the next one is occupied as well
/// @return vertices and triangles in S, in an order that depends on the volume's content only
/// Threads: reads the volume; needs its owner's permission.
/// Real-time: allocates; O(known blocks * log(known blocks)), voxels are only visited near a change
/// of sign.
[[nodiscard]] TriangleMesh extract_mesh(const VoxelStore& store, const Volume& volume,
                                        double voxel_size_m, double depth = 0);

}  // namespace cloister
