#pragma once

#include <vector>

#include <Eigen/Core>

#include "bench/simulate/convex_part.hpp"
#include "bench/simulate/random_stream.hpp"
#include "bench/simulate/triangle_mesh.hpp"

namespace cloister {

/// Appends a tree of 6 to 12 m: trunk, branches, and a crown of some 2,400 leaves in clusters,
/// through which about every third beam finds its way. Nothing hangs lower than 2.4 m.
void append_tree(const Eigen::Vector3d& foot_W, RandomStream* random, TriangleMesh* mesh,
                 std::vector<ConvexPart>* parts);

/// Appends a hedge from one foot to another: leaves, denser towards its middle.
void append_hedge(const Eigen::Vector3d& from_W, const Eigen::Vector3d& to_W, double width_m,
                  double height_m, RandomStream* random, TriangleMesh* mesh,
                  std::vector<ConvexPart>* parts);

}  // namespace cloister
