#include "bench/simulate/ply_file.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>

namespace cloister {

namespace {

enum class Type { kNone, kI8, kU8, kI16, kU16, kI32, kU32, kF32, kF64 };

Type type_of(const std::string& name) {
  static const std::map<std::string, Type> kTypes = {
      {"char", Type::kI8},    {"int8", Type::kI8},     {"uchar", Type::kU8},
      {"uint8", Type::kU8},   {"short", Type::kI16},   {"int16", Type::kI16},
      {"ushort", Type::kU16}, {"uint16", Type::kU16},  {"int", Type::kI32},
      {"int32", Type::kI32},  {"uint", Type::kU32},    {"uint32", Type::kU32},
      {"float", Type::kF32},  {"float32", Type::kF32}, {"double", Type::kF64},
      {"float64", Type::kF64}};
  const auto found = kTypes.find(name);
  return found == kTypes.end() ? Type::kNone : found->second;
}

struct Property {
  std::string name;
  Type type = Type::kNone;
  bool is_list = false;
  Type count_type = Type::kNone;  ///< of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::size_t size_of(Type type) {
  constexpr std::size_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

template <typename T>
double load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double number_of(Type type, const char* bytes) {
  switch (type) {
    case Type::kI8:
      return load<std::int8_t>(bytes);
    case Type::kU8:
      return load<std::uint8_t>(bytes);
    case Type::kI16:
      return load<std::int16_t>(bytes);
    case Type::kU16:
      return load<std::uint16_t>(bytes);
    case Type::kI32:
      return load<std::int32_t>(bytes);
    case Type::kU32:
      return load<std::uint32_t>(bytes);
    case Type::kF32:
      return load<float>(bytes);
    default:
      return load<double>(bytes);
  }
}

/// The body of a PLY file as a stream of numbers, whichever way they are written.
class Body {
 public:
  Body(std::string bytes, std::size_t offset, std::size_t line, bool ascii)
      : bytes_(std::move(bytes)), at_(offset), line_(line), ascii_(ascii) {}

  bool next(Type type, double* value) {
    if (!ascii_) {
      const std::size_t size = size_of(type);
      if (bytes_.size() - at_ < size) return false;
      *value = number_of(type, bytes_.data() + at_);
      at_ += size;
      return true;
    }
    while (at_ < bytes_.size() && std::strchr(" \t\r\n", bytes_[at_]) != nullptr) {
      line_ += bytes_[at_++] == '\n' ? 1 : 0;
    }
    const auto [end, error] =
        std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), *value);
    if (error != std::errc{}) return false;
    at_ = static_cast<std::size_t>(end - bytes_.data());
    return true;
  }

  [[nodiscard]] std::string place() const {
    return (ascii_ ? std::string(":") : std::string(" byte ")) +
           std::to_string(ascii_ ? line_ : at_);
  }

  [[nodiscard]] std::size_t bytes_left() const { return bytes_.size() - at_; }

 private:
  std::string bytes_;
  std::size_t at_;
  std::size_t line_;
  bool ascii_;
};

struct Header {
  std::vector<Element> elements;
  bool ascii = false;
  std::size_t num_lines = 0;
  std::size_t num_bytes = 0;
};

Result<Header> parse_header(const std::string& bytes, const std::string& file) {
  Header header;
  bool has_format = false;
  const auto bad = [&](const std::string& what) {
    return fail(ErrorKind::kInput, file + ":" + std::to_string(header.num_lines) + ": " + what);
  };
  while (true) {
    const std::size_t end = bytes.find('\n', header.num_bytes);
    if (end == std::string::npos)
      return bad("the PLY header has no end_header: the file is cut off");
    std::string line = bytes.substr(header.num_bytes, end - header.num_bytes);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    header.num_bytes = end + 1;
    ++header.num_lines;
    if (header.num_lines == 1) {
      if (line != "ply") return bad("not a PLY file: its first line must be \"ply\"");
      continue;
    }
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "end_header") break;
    if (word == "format") {
      words >> word;
      header.ascii = word == "ascii";
      if (!header.ascii && word != "binary_little_endian") {
        return bad("format " + word + " is not read: save it as ascii or binary_little_endian");
      }
      has_format = true;
    } else if (word == "element") {
      Element element;
      if (!(words >> element.name >> element.count))
        return bad("an element needs a name and a count");
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      Property property;
      words >> word;
      property.is_list = word == "list";
      if (property.is_list) {
        words >> word;
        property.count_type = type_of(word);
        words >> word;
      }
      property.type = type_of(word);
      words >> property.name;
      const bool is_known =
          property.type != Type::kNone && (!property.is_list || property.count_type != Type::kNone);
      if (!words || !is_known || header.elements.empty()) {
        return bad("a property that makes no sense: " + line);
      }
      header.elements.back().properties.push_back(std::move(property));
    } else if (word != "comment" && word != "obj_info" && !word.empty()) {
      return bad("unknown header line: " + line);
    }
  }
  if (!has_format) return bad("the header does not name a format");
  return header;
}

}  // namespace

Result<TriangleMesh> read_ply(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream.good() && !stream.eof()) {
    return fail(ErrorKind::kInput, path.string() + ": cannot be read: check the path");
  }
  const auto header = parse_header(bytes, path.string());
  if (!header) return tl::unexpected(header.error());
  Body body(std::move(bytes), header->num_bytes, header->num_lines + 1, header->ascii);
  const auto bad = [&](const std::string& what) {
    return fail(ErrorKind::kInput, path.string() + body.place() + ": " + what);
  };

  TriangleMesh mesh;
  for (const Element& element : header->elements) {
    if (element.properties.empty()) continue;
    if (element.count > body.bytes_left())
      return bad("fewer " + element.name + " entries than the header says");
    for (std::uint64_t k = 0; k < element.count; ++k) {
      Eigen::Vector3d vertex = Eigen::Vector3d::Constant(std::nan(""));
      for (const Property& property : element.properties) {
        double value = 0.0;
        if (!property.is_list) {
          if (!body.next(property.type, &value))
            return bad("a number is missing in element " + element.name);
          if (property.name == "x") vertex.x() = value;
          if (property.name == "y") vertex.y() = value;
          if (property.name == "z") vertex.z() = value;
          continue;
        }
        if (!body.next(property.count_type, &value) || value < 0.0)
          return bad("a list has no valid length");
        const bool is_face = element.name == "face" &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
        const auto length = static_cast<std::uint64_t>(value);
        std::array<std::uint32_t, 3> triangle{};
        for (std::uint64_t n = 0; n < length; ++n) {
          if (!body.next(property.type, &value)) return bad("a list is cut off");
          if (!is_face) continue;
          if (!(value >= 0.0) || value >= static_cast<double>(mesh.vertices.size())) {
            return bad("a face names vertex " + std::to_string(static_cast<std::int64_t>(value)) +
                       " of " + std::to_string(mesh.vertices.size()));
          }
          const auto index = static_cast<std::uint32_t>(value);
          if (n < 2) {
            triangle[n] = index;
            continue;
          }
          triangle[2] = index;
          mesh.triangles.push_back(triangle);
          triangle[1] = index;
        }
      }
      if (element.name != "vertex") continue;
      if (!vertex.allFinite()) return bad("a vertex without finite x, y and z");
      mesh.vertices.push_back(vertex.cast<float>());
    }
  }
  return mesh;
}

Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::ofstream stream(path, std::ios::binary);
  stream << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
         << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  stream.write(reinterpret_cast<const char*>(mesh.vertices.data()),
               static_cast<std::streamsize>(mesh.vertices.size() * sizeof(Eigen::Vector3f)));
  std::string faces;
  faces.reserve(mesh.triangles.size() * 13);
  for (const auto& triangle : mesh.triangles) {
    faces.push_back(3);
    faces.append(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
  }
  stream.write(faces.data(), static_cast<std::streamsize>(faces.size()));
  stream.close();
  if (!stream)
    return fail(ErrorKind::kResource,
                path.string() + ": cannot be written: check space and permissions");
  return {};
}

}  // namespace cloister
