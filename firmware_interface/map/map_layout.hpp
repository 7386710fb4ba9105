#pragma once

#include <array>
#include <cstdint>

#include "firmware_interface/map/chunk_record.hpp"

namespace cloister::map_layout {

// The fixed parts of a map file, byte by byte as they are written (see map_file.hpp).

inline constexpr std::array<char, 8> kMagic = {'C', 'L', 'O', 'I', 'S', 'T', 'E', 'R'};
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::uint64_t kChecksumBytes = sizeof(std::uint64_t);

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t header_bytes = 0;  ///< of this struct
  double voxel_size_m = 0;
  double log_odds_min = 0;
  double log_odds_max = 0;
  double log_odds_step = 0;
  std::uint64_t num_submaps = 0;
  std::uint64_t num_chunks = 0;
  std::uint64_t num_blocks = 0;
  std::uint64_t file_bytes = 0;
};
static_assert(sizeof(Header) == 80);

struct Description {
  std::int64_t id = 0;
  std::int64_t root = 0;
  std::array<double, 12> T_M_S{};
  std::array<double, 12> T_root_S{};
  std::uint64_t num_merged_from = 0;
  std::uint64_t num_nodes = 0;
  std::uint64_t num_stamps = 0;
  std::uint64_t num_chunks = 0;
  std::uint64_t num_blocks = 0;

  [[nodiscard]] std::uint64_t list_bytes() const {
    return num_merged_from * sizeof(std::int32_t) + (num_nodes + num_stamps) * sizeof(std::int64_t);
  }
  [[nodiscard]] std::uint64_t chunk_bytes() const {
    return num_chunks * sizeof(ChunkRecord) + num_blocks * sizeof(Block);
  }
};
static_assert(sizeof(Description) == 248);

/// Chunk coordinates within these bounds keep voxel coordinates, and sums of two, within 32 bits.
inline constexpr std::int32_t kMaxChunkCoord = 1 << 23;
/// The bound of positions in M, as for every pose that is read from a file.
inline constexpr double kMaxTranslation_m = 1e8;

}  // namespace cloister::map_layout
