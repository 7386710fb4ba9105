#pragma once

#include <filesystem>

#include "bench/simulate/triangle_mesh.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// Reads a polygon mesh, ascii or binary little endian. Faces of more than three corners are cut
/// into fans; other elements and properties are skipped. Vertex coordinates must be finite and face
/// indices must name vertices. Errors: kInput with file and line (ascii) or byte (binary).
[[nodiscard]] Result<TriangleMesh> read_ply(const std::filesystem::path& path);

/// Writes vertices and triangles, binary little endian. Errors: kResource when the disk refuses.
[[nodiscard]] Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace cloister
