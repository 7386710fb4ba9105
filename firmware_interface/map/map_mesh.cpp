#include "firmware_interface/map/map_mesh.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "mapping/mesh/drawn_surfaces.hpp"
#include "mapping/mesh/marching_cubes.hpp"
#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

/// A submap's mesh and what places and colours it.
struct Part {
  const Submap* submap = nullptr;
  TriangleMesh mesh;
};

struct WrittenPart {
  std::filesystem::path path;
  PlyMeshSize size;
};

void add_size(const PlyMeshSize& part, PlyMeshSize& sum) {
  sum.num_vertices += part.num_vertices;
  sum.num_triangles += part.num_triangles;
}

[[nodiscard]] PlyMeshSize size_of(const TriangleMesh& mesh) {
  return {mesh.vertices_S.size(), mesh.triangles.size()};
}

[[nodiscard]] Result<AtomicFile> open_mesh(const std::filesystem::path& path,
                                           const PlyMeshSize& size, PlyReal real) {
  if (size.num_vertices > std::numeric_limits<std::int32_t>::max()) {
    return fail(ErrorKind::kResource, path.string() + ": " + std::to_string(size.num_vertices) +
                                          " vertices are more than a PLY file can count; use "
                                          "the meshes of single submaps");
  }
  Result<AtomicFile> file = AtomicFile::open(path);
  if (file) static_cast<void>(file->write(ply_mesh_header(size, real)));
  return file;
}

[[nodiscard]] Result<void> write_parts(const std::filesystem::path& path,
                                       const std::vector<Part>& parts, PlyReal real) {
  PlyMeshSize size;
  for (const Part& part : parts) add_size(size_of(part.mesh), size);
  Result<AtomicFile> file = open_mesh(path, size, real);
  if (!file) return tl::unexpected(file.error());
  for (const Part& part : parts) {
    write_ply_vertices(part.mesh, part.submap->T_M_S, submap_colour(part.submap->id), real, *file);
  }
  std::uint64_t first_vertex = 0;
  for (const Part& part : parts) {
    write_ply_triangles(part.mesh, first_vertex, *file);
    first_vertex += part.mesh.vertices_S.size();
  }
  return file->commit();
}

/// Reads `num_bytes` of a file from `offset` on, and hands them over in pieces of whole records.
template <typename Consume>
[[nodiscard]] Result<void> read_pieces(const std::filesystem::path& path, std::uint64_t offset,
                                       std::uint64_t num_bytes, std::size_t record_bytes,
                                       Consume&& consume) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rbe"));
  bool is_good = file != nullptr && ::fseeko(file.get(), static_cast<off_t>(offset), SEEK_SET) == 0;
  std::vector<char> piece(4096 * record_bytes);
  for (std::uint64_t left = num_bytes; is_good && left > 0;) {
    const std::size_t size = std::min<std::uint64_t>(left, piece.size());
    is_good = std::fread(piece.data(), 1, size, file.get()) == size;
    if (is_good) consume(std::span(piece.data(), size));
    left -= size;
  }
  if (is_good) return {};
  return fail(ErrorKind::kResource,
              path.string() + ": cannot be read back: " + std::generic_category().message(errno) +
                  "; keep the output directory as it is while it is written");
}

/// Puts the mesh of the whole map together from the files of its submaps,
/// so that no two meshes are in memory at once.
[[nodiscard]] Result<void> join_parts(const std::filesystem::path& path,
                                      const std::vector<WrittenPart>& parts, PlyReal real) {
  PlyMeshSize size;
  for (const WrittenPart& part : parts) add_size(part.size, size);
  Result<AtomicFile> file = open_mesh(path, size, real);
  if (!file) return tl::unexpected(file.error());
  const auto write = [&](std::span<const char> piece) {
    static_cast<void>(file->write(std::as_bytes(piece)));
  };
  for (const WrittenPart& part : parts) {
    const std::size_t record_bytes = ply_vertex_bytes(real);
    auto done = read_pieces(part.path, ply_mesh_header(part.size, real).size(),
                            part.size.num_vertices * record_bytes, record_bytes, write);
    if (!done) return done;
  }
  std::int32_t first_vertex = 0;
  for (const WrittenPart& part : parts) {
    const std::uint64_t offset =
        ply_mesh_header(part.size, real).size() + part.size.num_vertices * ply_vertex_bytes(real);
    auto done = read_pieces(part.path, offset, part.size.num_triangles * kPlyTriangleBytes,
                            kPlyTriangleBytes, [&](std::span<char> piece) {
                              for (std::size_t at = 0; at < piece.size(); at += kPlyTriangleBytes) {
                                std::array<std::int32_t, 3> triangle;
                                std::memcpy(triangle.data(), &piece[at + 1], sizeof(triangle));
                                for (std::int32_t& vertex : triangle) vertex += first_vertex;
                                std::memcpy(&piece[at + 1], triangle.data(), sizeof(triangle));
                              }
                              write(piece);
                            });
    if (!done) return done;
    first_vertex += static_cast<std::int32_t>(part.size.num_vertices);
  }
  return file->commit();
}

/// Removes `<number>.ply` that an earlier run has left for a submap which is not among `parts`.
/// What cannot be removed stays; it does not make this map's meshes wrong.
void remove_other_submaps(const std::filesystem::path& directory,
                          const std::vector<WrittenPart>& parts) {
  std::error_code ignored;
  std::vector<std::filesystem::path> others;
  for (std::filesystem::directory_iterator it(directory, ignored), end; it != end;
       it.increment(ignored)) {
    const std::filesystem::path& path = it->path();
    const std::string stem = path.stem().string();
    SubmapId id = kNoSubmap;
    const auto [rest, error] = std::from_chars(stem.data(), stem.data() + stem.size(), id);
    const bool is_submap =
        error == std::errc() && rest == stem.data() + stem.size() && path.extension() == ".ply";
    const bool is_part = std::any_of(parts.begin(), parts.end(), [&](const WrittenPart& part) {
      return part.path.filename() == path.filename();
    });
    if (is_submap && !is_part) others.push_back(path);
  }
  for (const std::filesystem::path& path : others) std::filesystem::remove(path, ignored);
}

/// A submap's mesh without what other submaps' meshes show already.
[[nodiscard]] Part draw(const MapView& map, const Submap& submap, DrawnSurfaces& drawn) {
  Part part = {&submap,
               extract_mesh(*map.store, submap.volume, map.info.voxel_size_m, kSurfaceDepth)};
  drawn.leave_out(submap, part.mesh);
  drawn.add(submap);
  return part;
}

[[nodiscard]] tl::unexpected<Error> no_memory(const std::filesystem::path& path) {
  return fail(ErrorKind::kResource,
              path.string() + ": a mesh does not fit into memory; use larger voxels");
}

}  // namespace

PlyReal ply_real_for(const MapView& map) {
  constexpr double kMaxFloatReach_m = 1e4;
  double reach_m = 0;
  for (const Submap* submap : map.submaps) {
    const Eigen::AlignedBox3d box_S =
        known_bounds(*map.store, submap->volume, map.info.voxel_size_m);
    if (box_S.isEmpty()) continue;
    reach_m = std::max(reach_m, (submap->T_M_S * box_S.center()).cwiseAbs().maxCoeff() +
                                    0.5 * box_S.diagonal().norm());
  }
  return reach_m > kMaxFloatReach_m ? PlyReal::kDouble : PlyReal::kFloat;
}

Result<void> write_meshes(const std::filesystem::path& out_dir, const MapView& map) try {
  const std::filesystem::path directory = out_dir / "submaps";
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) {
    return fail(ErrorKind::kResource, directory.string() + ": cannot be created: " +
                                          error.message() + "; check the path and its permissions");
  }
  const PlyReal real = ply_real_for(map);
  std::vector<WrittenPart> written;
  std::vector<Part> parts(1);
  DrawnSurfaces drawn(*map.store, map.info.voxel_size_m);
  for (const Submap* submap : sorted_submaps(map)) {
    parts[0] = draw(map, *submap, drawn);
    const std::filesystem::path path = directory / (std::to_string(submap->id) + ".ply");
    if (auto done = write_parts(path, parts, real); !done) return done;
    written.push_back({path, size_of(parts[0].mesh)});
  }
  parts.clear();
  remove_other_submaps(directory, written);
  return join_parts(out_dir / "mesh.ply", written, real);
} catch (const std::bad_alloc&) {
  return no_memory(out_dir);
}

Result<void> write_mesh_ply(const std::filesystem::path& path, const MapView& map) try {
  std::vector<Part> parts;
  DrawnSurfaces drawn(*map.store, map.info.voxel_size_m);
  for (const Submap* submap : sorted_submaps(map)) parts.push_back(draw(map, *submap, drawn));
  return write_parts(path, parts, ply_real_for(map));
} catch (const std::bad_alloc&) {
  return no_memory(path);
}

}  // namespace cloister
