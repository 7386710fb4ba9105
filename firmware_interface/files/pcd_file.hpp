#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "mapping/core/result.hpp"

namespace cloister {

struct PcdStats {
  std::int64_t points = 0;  ///< appended
  /// Dropped, since a coordinate was NaN, infinite or too large for a float.
  std::int64_t not_finite = 0;
};

/// Reads the coordinates of a point cloud in PCD v0.7: DATA ascii, binary or binary_compressed,
/// organised or not.
///
/// The fields x, y and z are found by name and may be of any type (I, U, F) and size (1, 2, 4, 8
/// bytes); other fields are passed over. VIEWPOINT is not applied: points stay in the frame they
/// are written in. Bytes after the last point of a binary cloud are ignored, as PCL does.
///
/// @param file_name for messages
/// @param points_L finite points are appended, metres; unchanged when the read fails
/// @return counts, or kInput with file:line (header, ascii) or file and byte (binary)
///
/// Memory: bounded by the size of `bytes`, whatever its header claims (compressed: 88 times that,
/// which is as far as LZF expands).
[[nodiscard]] Result<PcdStats> read_pcd(std::string_view bytes, std::string_view file_name,
                                        std::vector<Eigen::Vector3f>& points_L);

/// The same from a file.
[[nodiscard]] Result<PcdStats> load_pcd(const std::filesystem::path& path,
                                        std::vector<Eigen::Vector3f>& points_L);

}  // namespace cloister
