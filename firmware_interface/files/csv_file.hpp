#pragma once

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/result.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// Reads the points of `cloister query`: lines `x,y,z` in metres, in M. A first line with these
/// names, in any case, is passed over; a text without points gives none.
/// @return kInput with file:line at the first malformed line
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> read_points_csv(std::string_view text,
                                                                   std::string_view file_name);
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> load_points_csv(
    const std::filesystem::path& path);

/// Reads the node pairs of `cloister uncertainty`: lines `i,j`, in the same way. Whether the nodes
/// exist is not known here.
using NodePair = std::pair<NodeId, NodeId>;
[[nodiscard]] Result<std::vector<NodePair>> read_pairs_csv(std::string_view text,
                                                           std::string_view file_name);
[[nodiscard]] Result<std::vector<NodePair>> load_pairs_csv(const std::filesystem::path& path);

}  // namespace cloister
