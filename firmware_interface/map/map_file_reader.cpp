#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include <sys/stat.h>

#include "firmware_interface/map/content_hash.hpp"
#include "firmware_interface/map/map_file.hpp"
#include "firmware_interface/map/map_layout.hpp"

namespace cloister {
namespace {

using map_layout::Description;
using map_layout::Header;
using map_layout::kChecksumBytes;

/// Reads a file from front to back, keeps its checksums, and knows the byte when something is
/// wrong.
class Reader {
 public:
  Reader(std::FILE* file, std::string name, std::uint64_t file_bytes)
      : file_(file), name_(std::move(name)), file_bytes_(file_bytes) {}

  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  [[nodiscard]] std::uint64_t bytes_left() const { return file_bytes_ - offset_; }
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }

  [[nodiscard]] Result<void> read(void* bytes, std::size_t size) {
    if (size > bytes_left()) return failure("the file ends too early; copy or write it again");
    if (std::fread(bytes, 1, size, file_) != size) {
      return failure("cannot be read: " + std::generic_category().message(errno));
    }
    offset_ += size;
    section_.add(bytes, size);
    whole_.add(bytes, size);
    return {};
  }
  template <typename Value>
  [[nodiscard]] Result<void> read(Value& value) {
    return read(&value, sizeof(value));
  }
  template <typename Value>
  [[nodiscard]] Result<void> read_list(std::vector<Value>& values, std::uint64_t count) {
    if (count > bytes_left() / sizeof(Value))
      return failure("a list runs past the end of the file");
    values.resize(count);
    return read(values.data(), count * sizeof(Value));
  }

  /// Compares the checksum that follows with that of everything since the last one.
  [[nodiscard]] Result<void> end_section(const char* what) {
    const std::uint64_t expected = section_.digest();
    auto checked = check(expected, what);
    section_.reset();
    return checked;
  }
  [[nodiscard]] Result<void> end_file() { return check(whole_.digest(), "file"); }

  [[nodiscard]] tl::unexpected<Error> failure(const std::string& problem) const {
    return failure_at(offset_, problem);
  }
  [[nodiscard]] tl::unexpected<Error> failure_at(std::uint64_t offset,
                                                 const std::string& problem) const {
    return fail(ErrorKind::kInput, name_ + ": byte " + std::to_string(offset) + ": " + problem);
  }

 private:
  [[nodiscard]] Result<void> check(std::uint64_t expected, const char* what) {
    const std::uint64_t at = offset_;
    std::uint64_t stored = 0;
    if (auto done = read(stored); !done) return done;
    if (stored != expected) {
      return failure_at(
          at, std::string("the checksum of the ") + what +
                  " before it does not match: the file is damaged; copy or write it again");
    }
    return {};
  }

  std::FILE* file_;
  std::string name_;
  std::uint64_t file_bytes_;
  std::uint64_t offset_ = 0;
  ContentHash section_;
  ContentHash whole_;
};

/// Nothing when the numbers are no rigid transform.
[[nodiscard]] std::optional<Pose> to_pose(const std::array<double, 12>& values) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(values.data());
  if (!matrix.allFinite()) return std::nullopt;
  Pose T_A_B = Pose::Identity();
  T_A_B.affine() = matrix;
  const Eigen::Matrix3d R = T_A_B.linear();
  const bool is_rigid = (R * R.transpose()).isIdentity(1e-6) && R.determinant() > 0 &&
                        T_A_B.translation().cwiseAbs().maxCoeff() <= map_layout::kMaxTranslation_m;
  return is_rigid ? std::optional(T_A_B) : std::nullopt;
}

[[nodiscard]] Result<Header> read_header(Reader& reader) {
  Header header;
  if (reader.bytes_left() < sizeof(header) || !reader.read(header) ||
      header.magic != map_layout::kMagic) {
    return reader.failure_at(
        0, "this is no map of Cloister; give the map.cloister that a replay left");
  }
  if (header.version != map_layout::kVersion || header.header_bytes != sizeof(Header)) {
    return reader.failure_at(8, "the map has version " + std::to_string(header.version) +
                                    ", this program reads version " +
                                    std::to_string(map_layout::kVersion) +
                                    "; replay the mission with this program");
  }
  if (auto done = reader.end_section("header"); !done) return tl::unexpected(done.error());
  const bool is_sane = std::isfinite(header.voxel_size_m) && header.voxel_size_m > 0 &&
                       std::isfinite(header.log_odds_min) && header.log_odds_min < 0 &&
                       std::isfinite(header.log_odds_max) && header.log_odds_max > 0 &&
                       header.log_odds_step == kLogOddsStep;
  if (!is_sane) return reader.failure_at(16, "voxel size or log-odds make no sense");
  if (header.file_bytes != reader.file_bytes()) {
    return reader.failure_at(reader.file_bytes(),
                             "the file should have " + std::to_string(header.file_bytes) +
                                 " bytes: it was cut off or added to; copy or write it again");
  }
  // What the counts ask for must be in the file, so no count can make the program allocate more
  // than that.
  const std::uint64_t left = reader.bytes_left();
  if (header.num_submaps > left / sizeof(Description) ||
      header.num_chunks > left / sizeof(ChunkRecord) || header.num_blocks > left / sizeof(Block) ||
      header.num_chunks >= kNoIndex || header.num_blocks >= Volume::kRestFlag) {
    return reader.failure_at(48, "the counts of the header exceed the file");
  }
  return header;
}

[[nodiscard]] Result<Description> read_description(Reader& reader, Submap& submap) {
  const std::uint64_t start = reader.offset();
  Description description;
  if (auto done = reader.read(description); !done) return tl::unexpected(done.error());
  if (auto done = reader.read_list(submap.merged_from, description.num_merged_from); !done) {
    return tl::unexpected(done.error());
  }
  if (auto done = reader.read_list(submap.nodes, description.num_nodes); !done) {
    return tl::unexpected(done.error());
  }
  if (auto done = reader.read_list(submap.scan_stamps, description.num_stamps); !done) {
    return tl::unexpected(done.error());
  }
  if (auto done = reader.end_section("submap's description"); !done) {
    return tl::unexpected(done.error());
  }
  submap.id = static_cast<SubmapId>(description.id);
  submap.root = description.root;
  const std::optional<Pose> T_M_S = to_pose(description.T_M_S);
  const std::optional<Pose> T_root_S = to_pose(description.T_root_S);
  if (submap.id != description.id || submap.id < 0) {
    return reader.failure_at(start, "a submap's id is out of range");
  }
  if (!T_M_S || !T_root_S) return reader.failure_at(start, "a submap's pose is no rigid transform");
  submap.T_M_S = *T_M_S;
  submap.T_root_S = *T_root_S;
  return description;
}

/// Reads one chunk into the volume. @param blocks_left  blocks that the submap may still have
[[nodiscard]] Result<void> read_chunk(Reader& reader, const ChunkRecord& record, VoxelPools& pools,
                                      Volume& volume, std::uint64_t& blocks_left) {
  const std::uint64_t start = reader.offset() - sizeof(record);
  const ChunkCoord coord(record.x, record.y, record.z);
  bool is_empty = true;
  for (int i = 0; i < kChunkBlocks; ++i) {
    const bool is_known = record.coarse[i] != kUnknownLogOdds;
    if (is_known != (record.known[i] != kNoOctants)) {
      return reader.failure_at(start, "a chunk's coarse node knows octants without a value, or a value without octants");
    }
    if (!record.is_block(i) && !is_known) continue;
    is_empty = false;
    const BlockCoord block_coord = coord * kChunkEdge + BlockCoord(i & 7, i >> 3 & 7, i >> 6);
    Chunk* chunk = nullptr;
    std::uint32_t* place = volume.make_place(pools, block_coord, &chunk);
    if (place == nullptr) return reader.failure_at(start, "more chunks than the header says");
    if (!record.is_block(i)) {
      volume.set_coarse(pools, *chunk, *place, record.coarse[i], record.known[i]);
      continue;
    }
    if (is_known || blocks_left == 0) {
      return reader.failure_at(start, "a chunk's blocks do not fit its submap's description");
    }
    --blocks_left;
    Block* block = volume.make_block(pools, *chunk, *place);
    if (block == nullptr) return reader.failure_at(start, "more blocks than the header says");
    if (auto done = reader.read(*block); !done) return done;
  }
  if (is_empty) return reader.failure_at(start, "a chunk knows nothing");
  return {};
}

[[nodiscard]] Result<void> read_submap(Reader& reader, VoxelPools& pools, Submap& submap) {
  const Result<Description> description = read_description(reader, submap);
  if (!description) return tl::unexpected(description.error());
  std::uint64_t blocks_left = description->num_blocks;
  ChunkRecord before{};
  for (std::uint64_t k = 0; k < description->num_chunks; ++k) {
    ChunkRecord record;
    if (auto done = reader.read(record); !done) return done;
    const auto is_far = [](std::int32_t c) {
      return c < -map_layout::kMaxChunkCoord || c > map_layout::kMaxChunkCoord;
    };
    const bool is_sorted = k == 0 || std::tuple(before.z, before.y, before.x) <
                                         std::tuple(record.z, record.y, record.x);
    if (is_far(record.x) || is_far(record.y) || is_far(record.z) || !is_sorted) {
      return reader.failure_at(reader.offset() - sizeof(record),
                               "a chunk's coordinate is out of range or out of order");
    }
    before = record;
    if (auto done = read_chunk(reader, record, pools, submap.volume, blocks_left); !done) {
      return done;
    }
  }
  if (blocks_left != 0)
    return reader.failure("a submap has fewer blocks than its description says");
  return reader.end_section("submap's chunks");
}

[[nodiscard]] Result<LoadedMap> read_map(Reader& reader) {
  const Result<Header> header = read_header(reader);
  if (!header) return tl::unexpected(header.error());
  LoadedMap map;
  map.info = {header->voxel_size_m, header->log_odds_min, header->log_odds_max};
  map.store = std::make_unique<VoxelStore>(header->num_blocks, header->num_chunks);
  map.pools = std::make_unique<VoxelPools>(*map.store);
  map.pools->take_all();
  for (std::uint64_t k = 0; k < header->num_submaps; ++k) {
    const std::uint64_t start = reader.offset();
    Submap submap;
    if (auto done = read_submap(reader, *map.pools, submap); !done) {
      return tl::unexpected(done.error());
    }
    if (k > 0 && submap.id <= map.submaps.back().id) {
      return reader.failure_at(start, "submaps are not in the order of their ids");
    }
    map.submaps.push_back(std::move(submap));
  }
  if (map.pools->chunks.num_free() != 0 || map.pools->blocks.num_free() != 0) {
    return reader.failure("fewer chunks or blocks than the header says");
  }
  if (auto done = reader.end_file(); !done) return tl::unexpected(done.error());
  if (reader.bytes_left() != 0) return reader.failure("the map ends here, the file goes on");
  for (const Submap& submap : map.submaps) map.submap_ptrs.push_back(&submap);
  return map;
}

}  // namespace

Result<LoadedMap> load_map(const std::filesystem::path& path) {
  const auto cannot_open = [&](int error) {
    return fail(ErrorKind::kInput,
                path.string() + ": cannot be opened: " + std::generic_category().message(error) +
                    "; check the path and its permissions");
  };
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rbe"));
  if (file == nullptr) return cannot_open(errno);
  struct stat status = {};
  if (::fstat(::fileno(file.get()), &status) != 0) return cannot_open(errno);
  if (!S_ISREG(status.st_mode)) return cannot_open(S_ISDIR(status.st_mode) ? EISDIR : ESPIPE);
  try {
    Reader reader(file.get(), path.string(), static_cast<std::uint64_t>(status.st_size));
    return read_map(reader);
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::kResource, path.string() + ": the map of " +
                                          std::to_string(status.st_size) +
                                          " bytes does not fit into memory");
  }
}

}  // namespace cloister
