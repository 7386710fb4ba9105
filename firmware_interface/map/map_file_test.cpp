#include "firmware_interface/map/map_file.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/map/content_hash.hpp"
#include "firmware_interface/map/map_builder_for_tests.hpp"
#include "firmware_interface/map/map_hash.hpp"
#include "firmware_interface/map/map_layout.hpp"

namespace cloister {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

void fill(MapBuilder& map) {
  Submap& first = map.add_submap(3, pose_of(1.5, -2.25, 0.125, 0.3, 0.1));
  map.fill_randomly(first, 1);
  first.merged_from = {4, 9};
  first.root = 17;
  first.T_root_S = pose_of(0.1, 0.2, 0.3, -0.4);
  first.nodes = {17, 18, 40};
  first.scan_stamps = {{1000000007}, {-5}, {1630577758469490000}};
  map.add_submap(5);  // knows nothing
  map.fill_randomly(map.add_submap(0, pose_of(100, 0, 0, 0)), 2, 70);
}

void check_same(const Submap& a, const VoxelStore& store_a, const Submap& b,
                const VoxelStore& store_b) {
  CHECK(a.id == b.id);
  CHECK(a.merged_from == b.merged_from);
  CHECK(a.root == b.root);
  CHECK(a.T_M_S.matrix() == b.T_M_S.matrix());
  CHECK(a.T_root_S.matrix() == b.T_root_S.matrix());
  CHECK(a.nodes == b.nodes);
  CHECK(a.scan_stamps == b.scan_stamps);
  CHECK(a.volume.num_blocks() == b.volume.num_blocks());
  CHECK(a.volume.num_chunks() == b.volume.num_chunks());
  a.volume.for_each_block(store_a, [&](const BlockCoord& coord, const BlockView& view) {
    const BlockView other = b.volume.view(store_b, coord);
    REQUIRE((view.block == nullptr) == (other.block == nullptr));
    CHECK(view.coarse == other.coarse);
    CHECK(view.known == other.known);
    if (view.block != nullptr) CHECK(std::memcmp(view.block, other.block, sizeof(Block)) == 0);
  });
}

TEST_CASE("a copy of a map says what the map says, in memory of its own") {
  MapBuilder map;
  fill(map);
  const LoadedMap copy = copy_map(map.view());
  CHECK(map_hash(*copy.store, copy.submap_ptrs) == map_hash(map.store, map.view().submaps));
  CHECK(copy.submaps.size() == map.view().submaps.size());
  CHECK(copy.pools->blocks.num_free() == 0);
  CHECK(copy.pools->chunks.num_free() == 0);
}

TEST_CASE("a map comes back from its file exactly as it was saved") {
  MapBuilder map;
  fill(map);
  const ScratchDirectory directory;
  REQUIRE(save_map(directory / "map.cloister", map.view()).has_value());
  const auto loaded = load_map(directory / "map.cloister");
  REQUIRE_MESSAGE(loaded.has_value(), loaded.error().message);
  CHECK(loaded->info.voxel_size_m == map.info.voxel_size_m);
  CHECK(loaded->info.log_odds_min == map.info.log_odds_min);
  CHECK(loaded->info.log_odds_max == map.info.log_odds_max);
  REQUIRE(loaded->submaps.size() == 3);
  const auto expected = sorted_submaps(map.view());
  for (std::size_t i = 0; i < 3; ++i) {
    check_same(*expected[i], map.store, loaded->submaps[i], *loaded->store);
    CHECK(loaded->submap_ptrs[i] == &loaded->submaps[i]);
  }
  CHECK(loaded->store->num_blocks() ==
        expected[0]->volume.num_blocks() + expected[1]->volume.num_blocks());
  CHECK(map_hash(*loaded->store, loaded->submap_ptrs) == map_hash(map.store, map.submap_ptrs));

  REQUIRE(save_map(directory / "again.cloister", loaded->view()).has_value());
  CHECK(bytes_of(directory / "again.cloister") == bytes_of(directory / "map.cloister"));
}

TEST_CASE("coarse nodes come back from the file with the octants they know") {
  MapBuilder map;
  Submap& submap = map.add_submap(1);
  for (int known = 1; known < 256; ++known) {
    map.set_coarse(submap, {known % 16, known / 16, -3}, static_cast<LogOdds>(-1 - known % 40),
                   static_cast<OctantMask>(known));
  }
  const ScratchDirectory directory;
  REQUIRE(save_map(directory / "map.cloister", map.view()).has_value());
  const auto loaded = load_map(directory / "map.cloister");
  REQUIRE_MESSAGE(loaded.has_value(), loaded.error().message);
  check_same(submap, map.store, loaded->submaps[0], *loaded->store);
  for (int known = 1; known < 256; ++known) {
    const BlockView view =
        loaded->submaps[0].volume.view(*loaded->store, {known % 16, known / 16, -3});
    CHECK(view.block == nullptr);
    CHECK(int{view.known} == known);
    CHECK(int{view.coarse} == -1 - known % 40);
  }
}

TEST_CASE("a map without submaps is a map") {
  const MapBuilder map(0, 0);
  const ScratchDirectory directory;
  REQUIRE(save_map(directory / "empty.cloister", map.view()).has_value());
  const auto loaded = load_map(directory / "empty.cloister");
  REQUIRE_MESSAGE(loaded.has_value(), loaded.error().message);
  CHECK(loaded->submaps.empty());
}

TEST_CASE("a flipped bit anywhere is noticed") {
  MapBuilder map;
  Submap& submap = map.add_submap(1);
  map.set_voxel(submap, {0, 0, 0}, 5);
  map.set_coarse(submap, {9, 0, 0}, -5);
  submap.nodes = {1, 2, 3};
  const ScratchDirectory directory;
  REQUIRE(save_map(directory / "map.cloister", map.view()).has_value());
  const std::string good = bytes_of(directory / "map.cloister");
  const auto damaged_path = directory / "damaged.cloister";
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    write_bytes(damaged_path, bad);
    const auto loaded = load_map(damaged_path);
    CAPTURE(at);
    REQUIRE(!loaded.has_value());
    CHECK(loaded.error().kind == ErrorKind::kInput);
    CHECK(loaded.error().message.find("damaged.cloister: byte ") != std::string::npos);
    CHECK(loaded.error().message.find('\n') == std::string::npos);
  }
}

TEST_CASE("a file that is cut off anywhere, or longer than it should be, is refused") {
  MapBuilder map;
  map.set_voxel(map.add_submap(1), {0, 0, 0}, 5);
  const ScratchDirectory directory;
  REQUIRE(save_map(directory / "map.cloister", map.view()).has_value());
  const std::string good = bytes_of(directory / "map.cloister");
  const auto path = directory / "cut.cloister";
  for (std::size_t size = 0; size < good.size(); size += size < 400 ? 1 : 37) {
    write_bytes(path, good.substr(0, size));
    CAPTURE(size);
    const auto loaded = load_map(path);
    REQUIRE(!loaded.has_value());
    CHECK(loaded.error().kind == ErrorKind::kInput);
  }
  write_bytes(path, good + "x");
  CHECK(!load_map(path).has_value());
}

TEST_CASE("other files, other versions and missing files are refused with a reason") {
  MapBuilder map;
  const ScratchDirectory directory;
  const auto path = directory / "map.cloister";
  REQUIRE(save_map(path, map.view()).has_value());
  std::string bytes = bytes_of(path);
  bytes[8] = 9;
  write_bytes(path, bytes);
  CHECK(load_map(path).error().message.find("version 9") != std::string::npos);
  write_bytes(path, "ply\nformat ascii 1.0\n");
  CHECK(load_map(path).error().message.find("no map of Cloister") != std::string::npos);
  CHECK(load_map(directory / "missing").error().kind == ErrorKind::kInput);
  CHECK(load_map(directory.path()).error().kind == ErrorKind::kInput);
  CHECK(save_map(directory / "no/such/folder.cloister", map.view()).error().kind ==
        ErrorKind::kResource);
}

/// Puts right the checksums of a file with one submap, so that only its content is wrong.
void restore_checksums(std::string& bytes) {
  using namespace map_layout;
  ContentHash hash;
  const auto put = [&](std::size_t begin, std::size_t end) {
    hash.reset();
    hash.add(bytes.data() + begin, end - begin);
    const std::uint64_t digest = hash.digest();
    std::memcpy(bytes.data() + end, &digest, sizeof(digest));
  };
  Description description;
  const std::size_t description_begin = sizeof(Header) + kChecksumBytes;
  std::memcpy(&description, bytes.data() + description_begin, sizeof(description));
  put(0, sizeof(Header));
  const std::size_t lists = std::min<std::uint64_t>(description.list_bytes(), 1000);
  const std::size_t description_end = description_begin + sizeof(Description) + lists;
  if (description_end + 24 > bytes.size()) return;
  put(description_begin, description_end);
  put(description_end + kChecksumBytes, bytes.size() - 2 * kChecksumBytes);
  put(0, bytes.size() - kChecksumBytes);
}

TEST_CASE("content that lies is refused even when its checksums are right") {
  using map_layout::Description;
  using map_layout::Header;
  MapBuilder map;
  Submap& submap = map.add_submap(1);
  map.set_voxel(submap, {0, 0, 0}, 5);
  map.set_coarse(submap, {9, 0, 0}, -5);
  submap.nodes = {1, 2, 3};
  const ScratchDirectory directory;
  const auto path = directory / "map.cloister";
  REQUIRE(save_map(path, map.view()).has_value());
  std::string good = bytes_of(path);
  {
    std::string same = good;
    restore_checksums(same);
    REQUIRE(same == good);
  }
  const unsigned seed = 5;
  CAPTURE(seed);
  std::mt19937_64 rng(seed);
  int num_refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bad = good;
    const std::size_t at = 16 + rng() % (good.size() - 24);
    const std::uint64_t value = rng() >> (rng() % 8 * 8);
    std::memcpy(bad.data() + at, &value, 1 + rng() % 8);
    restore_checksums(bad);
    write_bytes(path, bad);
    const auto loaded = load_map(path);
    if (!loaded) {
      ++num_refused;
      CHECK(loaded.error().kind == ErrorKind::kInput);
    }
  }
  CHECK(num_refused > 100);

  const std::size_t d = sizeof(Header) + map_layout::kChecksumBytes;
  const auto refused = [&](std::size_t offset, auto value) {
    std::string bad = good;
    std::memcpy(bad.data() + offset, &value, sizeof(value));
    restore_checksums(bad);
    write_bytes(path, bad);
    return !load_map(path).has_value();
  };
  CHECK(refused(offsetof(Header, voxel_size_m), -1.0));
  CHECK(refused(offsetof(Header, num_submaps), std::uint64_t{2}));
  CHECK(refused(offsetof(Header, num_chunks), std::uint64_t{1} << 40));
  CHECK(refused(offsetof(Header, num_blocks), std::uint64_t{3}));
  CHECK(refused(d + offsetof(Description, id), std::int64_t{-1}));
  CHECK(refused(d + offsetof(Description, id), std::int64_t{1} << 32));
  CHECK(refused(d + offsetof(Description, T_M_S), 2.0));
  CHECK(refused(d + offsetof(Description, num_nodes), ~std::uint64_t{0}));
  CHECK(refused(d + offsetof(Description, num_chunks), std::uint64_t{1}));
  CHECK(refused(d + offsetof(Description, num_blocks), std::uint64_t{0}));
  // Block (9, 0, 0) is place 1 of the second chunk: nodes and the first chunk with its block come before.
  const std::size_t second_chunk = d + sizeof(Description) + 3 * sizeof(NodeId) +
                                   map_layout::kChecksumBytes + sizeof(ChunkRecord) + sizeof(Block);
  CHECK(refused(second_chunk + offsetof(ChunkRecord, known) + 1, kNoOctants));
  CHECK(refused(second_chunk + offsetof(ChunkRecord, coarse) + 1, kUnknownLogOdds));
  CHECK(refused(second_chunk + offsetof(ChunkRecord, known) + 2, OctantMask{4}));
  CHECK_FALSE(refused(second_chunk + offsetof(ChunkRecord, known) + 1, OctantMask{4}));
}

TEST_CASE("the map hash does not see pools and orders, but every change of content") {
  MapBuilder a, b;
  Submap& a0 = a.add_submap(0);
  Submap& a1 = a.add_submap(1, pose_of(1, 2, 3, 0.5));
  Submap& b1 = b.add_submap(1, pose_of(1, 2, 3, 0.5));
  Submap& b0 = b.add_submap(0);
  for (int i = 0; i < 50; ++i) {
    a.set_voxel(a0, {i * 20 - 500, 3 * i, -i}, static_cast<LogOdds>(i + 1));
    a.set_voxel(a1, {-i, i * 9, i}, static_cast<LogOdds>(-i - 1));
    const int k = 49 - i;
    b.set_voxel(b1, {-k, k * 9, k}, static_cast<LogOdds>(-k - 1));
    b.set_voxel(b0, {k * 20 - 500, 3 * k, -k}, static_cast<LogOdds>(k + 1));
  }
  const auto hash = [](const MapBuilder& map) { return map_hash(map.store, map.submap_ptrs); };
  const std::uint64_t before = hash(a);
  CHECK(before == hash(b));

  b0.T_M_S.translation().x() = 1e-300;
  CHECK(before != hash(b));
  b0.T_M_S = Pose::Identity();
  CHECK(before == hash(b));
  b.set_voxel(b0, {-500, 0, 0}, 2);
  CHECK(before != hash(b));
  b.set_voxel(b0, {-500, 0, 0}, 1);
  b.set_coarse(b1, {1000, 0, 0}, -1);
  CHECK(before != hash(b));
  b.set_coarse(b1, {1000, 0, 0}, 0);
  CHECK(before == hash(b));
  a.set_coarse(a1, {1000, 0, 0}, -1, 0x35);
  b.set_coarse(b1, {1000, 0, 0}, -1, 0x34);
  CHECK(hash(a) != hash(b));
  b.set_coarse(b1, {1000, 0, 0}, -1, 0x35);
  CHECK(hash(a) == hash(b));
  b0.id = 2;
  CHECK(hash(a) != hash(b));
}

}  // namespace
}  // namespace cloister
