#pragma once

#include <filesystem>

#include "firmware_interface/map/map_contents.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// `map.cloister`, version 2: everything that `query` and `export` need. Little-endian, no padding,
/// no compression.
///
/// | part                  | content                                                              |
/// |-----------------------|----------------------------------------------------------------------|
/// | header                | magic "CLOISTER", u32 version, u32 header bytes, f64 voxel_size_m,   |
/// |                       | log_odds_min, log_odds_max and log-odds of one step, u64 submaps,    |
/// |                       | chunks, blocks and file bytes                                        |
/// | its checksum          | u64                                                                  |
/// | submaps, by id:       |                                                                      |
/// | - description         | i64 id and root node, f64[12] T_M_S and T_root_S (3x4, row-major),   |
/// |                       | u64 counts of merged_from, nodes, stamps, chunks and blocks; then    |
/// |                       | i32 merged_from[], i64 nodes[], i64 stamps_ns[]                      |
/// | - its checksum        | u64                                                                  |
/// | - chunks, by (z, y, x)| i32 x, y, z; i8[512] coarse values; u8[512] octants that have them;  |
/// |                       | 512 bits that say which places have a block; then those blocks,      |
/// |                       | i8[512] each (places and voxels: x fastest, then y, then z)          |
/// | - their checksum      | u64                                                                  |
/// | end                   | u64 checksum of the whole file before it                             |
///
/// Checksums are XXH3-64. The bytes depend on the map's content only, so equal maps are equal
/// files.

/// Writes the map; the file appears when it is complete. Streams chunk by chunk.
/// Fails with kResource when it cannot be written.
[[nodiscard]] Result<void> save_map(const std::filesystem::path& path, const MapView& map);

/// Reads a map back. Nothing is allocated that the file's own size does not bear out.
/// Fails with kInput, naming the file and the byte, when it is missing, of another version, cut off
/// or damaged; with kResource when it does not fit into memory.
[[nodiscard]] Result<LoadedMap> load_map(const std::filesystem::path& path);

}  // namespace cloister
