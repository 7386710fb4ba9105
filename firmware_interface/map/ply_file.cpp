#include "firmware_interface/map/ply_file.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <span>

namespace cloister {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PLY bodies are written as memory holds them");

/// One element of the file, put together field by field.
class Record {
 public:
  template <typename Value>
  void add(Value value) {
    std::memcpy(bytes_.data() + size_, &value, sizeof(value));
    size_ += sizeof(value);
  }
  void add(const Eigen::Vector3d& point, PlyReal real) {
    for (const double coordinate : point) {
      if (real == PlyReal::kFloat) {
        add(static_cast<float>(coordinate));
      } else {
        add(coordinate);
      }
    }
  }
  void add(Rgb colour) {
    add(colour.r);
    add(colour.g);
    add(colour.b);
  }
  /// A failure stays with the file until its commit.
  void write(AtomicFile& file) const {
    static_cast<void>(file.write(std::as_bytes(std::span(bytes_.data(), size_))));
  }

 private:
  std::array<char, 32> bytes_;
  std::size_t size_ = 0;
};

[[nodiscard]] std::string vertex_header(std::uint64_t num_vertices, PlyReal real) {
  const std::string type = real == PlyReal::kFloat ? "float" : "double";
  std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment Cloister map, metres, frame M\n";
  header += "element vertex " + std::to_string(num_vertices) + '\n';
  for (const char* axis : {"x", "y", "z"}) header += "property " + type + ' ' + axis + '\n';
  for (const char* name : {"red", "green", "blue"}) {
    header += std::string("property uchar ") + name + '\n';
  }
  return header;
}

}  // namespace

std::string ply_mesh_header(const PlyMeshSize& size, PlyReal real) {
  return vertex_header(size.num_vertices, real) + "element face " +
         std::to_string(size.num_triangles) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

void write_ply_vertices(const TriangleMesh& mesh, const Pose& T_M_S, Rgb colour, PlyReal real,
                        AtomicFile& file) {
  for (const Eigen::Vector3f& p_S : mesh.vertices_S) {
    Record record;
    record.add(T_M_S * p_S.cast<double>(), real);
    record.add(colour);
    record.write(file);
  }
}

void write_ply_triangles(const TriangleMesh& mesh, std::uint64_t first_vertex, AtomicFile& file) {
  for (const auto& triangle : mesh.triangles) {
    Record record;
    record.add(std::uint8_t{3});
    for (const std::uint32_t vertex : triangle) {
      record.add(static_cast<std::int32_t>(first_vertex + vertex));
    }
    record.write(file);
  }
}

std::string ply_cloud_header(std::uint64_t num_points, PlyReal real) {
  return vertex_header(num_points, real) + "property int submap\nend_header\n";
}

void write_ply_point(const Eigen::Vector3d& p_M, Rgb colour, std::int32_t submap, PlyReal real,
                     AtomicFile& file) {
  Record record;
  record.add(p_M, real);
  record.add(colour);
  record.add(submap);
  record.write(file);
}

}  // namespace cloister
