#include <span>
#include <string>
#include <utility>
#include <vector>

#include "firmware_interface/files/atomic_file.hpp"
#include "firmware_interface/map/content_hash.hpp"
#include "firmware_interface/map/map_file.hpp"
#include "firmware_interface/map/map_layout.hpp"

namespace cloister {
namespace {

using map_layout::Description;
using map_layout::Header;
using map_layout::kChecksumBytes;

/// Sends bytes to the file and to two checksums.
/// Failures stick to the file, so only the commit is checked.
class Writer {
 public:
  explicit Writer(AtomicFile& file) : file_(file) {}

  void write(const void* bytes, std::size_t size) {
    section_.add(bytes, size);
    write_raw(bytes, size);
  }
  template <typename Value>
  void write(const Value& value) {
    write(&value, sizeof(value));
  }
  void end_section() {
    const std::uint64_t checksum = section_.digest();
    section_.reset();
    write_raw(&checksum, sizeof(checksum));
  }
  void end_file() {
    const std::uint64_t checksum = whole_.digest();
    write_raw(&checksum, sizeof(checksum));
  }

 private:
  void write_raw(const void* bytes, std::size_t size) {
    whole_.add(bytes, size);
    static_cast<void>(file_.write(std::span(static_cast<const std::byte*>(bytes), size)));
  }

  AtomicFile& file_;
  ContentHash section_;
  ContentHash whole_;
};

[[nodiscard]] std::array<double, 12> to_array(const Pose& T_A_B) {
  std::array<double, 12> values;
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(values.data()) = T_A_B.affine();
  return values;
}

[[nodiscard]] Description describe(const Submap& submap, std::size_t num_chunks) {
  Description description;
  description.id = submap.id;
  description.root = submap.root;
  description.T_M_S = to_array(submap.T_M_S);
  description.T_root_S = to_array(submap.T_root_S);
  description.num_merged_from = submap.merged_from.size();
  description.num_nodes = submap.nodes.size();
  description.num_stamps = submap.scan_stamps.size();
  description.num_chunks = num_chunks;
  description.num_blocks = submap.volume.num_blocks();
  return description;
}

void write_submap(const VoxelStore& store, const Submap& submap, Writer& writer) {
  const std::vector<const Chunk*> chunks = sorted_chunks(store, submap.volume);
  writer.write(describe(submap, chunks.size()));
  writer.write(submap.merged_from.data(), submap.merged_from.size() * sizeof(SubmapId));
  writer.write(submap.nodes.data(), submap.nodes.size() * sizeof(NodeId));
  static_assert(sizeof(SensorTime) == sizeof(std::int64_t));
  writer.write(submap.scan_stamps.data(), submap.scan_stamps.size() * sizeof(SensorTime));
  writer.end_section();
  for (const Chunk* chunk : chunks) {
    writer.write(make_chunk_record(*chunk));
    for (const std::uint32_t place : chunk->places) {
      if (Volume::has_block(place)) writer.write(store.block(Volume::block_index(place)));
    }
  }
  writer.end_section();
}

}  // namespace

Result<void> save_map(const std::filesystem::path& path, const MapView& map) {
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());

  const std::vector<const Submap*> submaps = sorted_submaps(map);
  Header header;
  header.header_bytes = sizeof(Header);
  header.voxel_size_m = map.info.voxel_size_m;
  header.log_odds_min = map.info.log_odds_min;
  header.log_odds_max = map.info.log_odds_max;
  header.log_odds_step = kLogOddsStep;
  header.num_submaps = submaps.size();
  header.file_bytes = sizeof(Header) + 2 * kChecksumBytes;
  for (const Submap* submap : submaps) {
    const Description description =
        describe(*submap, sorted_chunks(*map.store, submap->volume).size());
    header.num_chunks += description.num_chunks;
    header.num_blocks += description.num_blocks;
    header.file_bytes += sizeof(Description) + description.list_bytes() +
                         description.chunk_bytes() + 2 * kChecksumBytes;
  }

  Writer writer(*file);
  writer.write(header);
  writer.end_section();
  for (const Submap* submap : submaps) write_submap(*map.store, *submap, writer);
  writer.end_file();
  return file->commit();
}

}  // namespace cloister
