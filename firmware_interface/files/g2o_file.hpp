#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "mapping/core/result.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

struct G2oOptions {
  /// Stands in for missing information matrices as a scaled identity, 1/m^2 and 1/rad^2;
  /// 0 refuses such edges.
  double default_information = 0.0;
};

/// What a reader passed over.
struct G2oStats {
  std::int64_t comments = 0;           ///< lines that hold only a comment
  std::int64_t skipped_records = 0;    ///< FIX, PLATFORM_ID and every other record that is not read
  std::int64_t repeated_vertices = 0;  ///< vertices written again with the same content
  std::int64_t edges_without_information = 0;  ///< edges that got the default
};

/// Reads a pose graph in g2o text (also as the .slam files of the Oxford tools):
///
///     VERTEX_SE3:QUAT_TIME id x y z qx qy qz qw sec nsec
///     VERTEX_SE3:QUAT      id x y z qx qy qz qw
///     EDGE_SE3:QUAT        i j x y z qx qy qz qw  [21 numbers]
///
/// The 21 numbers are the upper triangle of the information matrix by rows. Information is over
/// (translation, rotation) and is taken as that of a rotation vector in radians. Lines come in any
/// order, ids are any integers from 0 on, an edge may point backwards and may repeat another.
/// Quaternions are normalised. A text without vertices gives an empty graph.
///
/// Refused at their line: wrong counts of numbers, numbers that are not finite, a vertex id that
/// returns with other content, an edge that names an unknown node or the same node twice,
/// information that is not positive semidefinite (with its diagonal scaled to one: an eigenvalue
/// below -1e-6, which leaves room for six printed digits).
///
/// @param file_name for messages
/// @param stats filled when not null; meaningful only on success
/// @return the graph, nodes sorted by id, edges in the order written, `PoseGraph::stamp` zero;
///         or kInput with file:line
///
/// Cost: O(n log n), about 10 ms for 6,275 edges with information.
[[nodiscard]] Result<PoseGraph> read_g2o(std::string_view text, std::string_view file_name,
                                         const G2oOptions& options, G2oStats* stats = nullptr);

/// The same from a file.
[[nodiscard]] Result<PoseGraph> load_g2o(const std::filesystem::path& path,
                                         const G2oOptions& options, G2oStats* stats = nullptr);

}  // namespace cloister
