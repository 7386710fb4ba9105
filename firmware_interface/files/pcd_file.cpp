#include "firmware_interface/files/pcd_file.hpp"

#include <lzf.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "firmware_interface/files/line_reader.hpp"
#include "firmware_interface/files/pcd_header.hpp"
#include "firmware_interface/files/read_file.hpp"

namespace cloister {
namespace {

static_assert(std::endian::native == std::endian::little, "PCD bodies are read as they stand");

/// LZF spends at least 3 bytes on a match, and a match is at most 264 bytes long.
constexpr std::size_t kMaxExpansion = 264 / 3;

template <typename T>
float load_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<float>(value);
}

template <>
float load_as<double>(const char* bytes) {
  double value;
  std::memcpy(&value, bytes, sizeof(value));
  // Beyond a float's range the conversion is undefined behaviour;
  // such a coordinate is dropped as not finite.
  return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max())
             ? static_cast<float>(value)
             : std::numeric_limits<float>::quiet_NaN();
}

using LoadCoordinate = float (*)(const char*);

/// How a value of this type and size is read; a checked header has no others than those here.
LoadCoordinate loader_of(const PcdField& field) {
  switch (field.size) {
    case 1:
      return field.type == 'I' ? &load_as<std::int8_t> : &load_as<std::uint8_t>;
    case 2:
      return field.type == 'I' ? &load_as<std::int16_t> : &load_as<std::uint16_t>;
    case 4:
      if (field.type == 'F') return &load_as<float>;
      return field.type == 'I' ? &load_as<std::int32_t> : &load_as<std::uint32_t>;
    default:
      if (field.type == 'F') return &load_as<double>;
      return field.type == 'I' ? &load_as<std::int64_t> : &load_as<std::uint64_t>;
  }
}

/// Collects points and leaves the caller's vector as it was unless everything went well.
class PointSink {
 public:
  PointSink(std::vector<Eigen::Vector3f>& points, std::size_t num_expected)
      : points_(points), num_before_(points.size()) {
    points_.reserve(num_before_ + num_expected);
  }
  PointSink(const PointSink&) = delete;
  PointSink& operator=(const PointSink&) = delete;
  ~PointSink() { points_.resize(num_kept_.value_or(num_before_)); }

  void add(const Eigen::Vector3f& point) {
    if (point.allFinite()) {
      points_.push_back(point);
    } else {
      ++num_not_finite_;
    }
  }

  PcdStats keep() {
    num_kept_ = points_.size();
    return {static_cast<std::int64_t>(points_.size() - num_before_), num_not_finite_};
  }

 private:
  std::vector<Eigen::Vector3f>& points_;
  std::size_t num_before_;
  std::int64_t num_not_finite_ = 0;
  std::optional<std::size_t> num_kept_;
};

tl::unexpected<Error> fail_at_byte(std::string_view file_name, std::size_t byte,
                                   std::string_view problem) {
  return fail(ErrorKind::kInput, std::string(file_name) + ": byte " + std::to_string(byte) + ": " +
                                     std::string(problem));
}

/// Reads points whose coordinate `axis` of point k lies at `begin[axis] + k * stride[axis]`.
void read_strided(const std::array<const char*, 3>& begin, const std::array<std::size_t, 3>& stride,
                  const PcdHeader& header, PointSink& sink) {
  const std::array<LoadCoordinate, 3> load = {loader_of(header.xyz[0]), loader_of(header.xyz[1]),
                                              loader_of(header.xyz[2])};
  for (std::size_t k = 0; k < header.num_points; ++k) {
    sink.add({load[0](begin[0] + k * stride[0]), load[1](begin[1] + k * stride[1]),
              load[2](begin[2] + k * stride[2])});
  }
}

Result<PcdStats> read_binary(std::string_view body, std::string_view file_name,
                             const PcdHeader& header, std::vector<Eigen::Vector3f>& points_L) {
  // Division, since the product may not fit.
  if (header.num_points > body.size() / header.record_bytes) {
    return fail_at_byte(file_name, header.body_begin + body.size(),
                        "the file ends before its " + std::to_string(header.num_points) +
                            " points of " + std::to_string(header.record_bytes) +
                            " bytes do; it is cut off or its header is wrong");
  }
  PointSink sink(points_L, header.num_points);
  std::array<const char*, 3> begin;
  for (std::size_t axis = 0; axis < 3; ++axis) begin[axis] = body.data() + header.xyz[axis].offset;
  read_strided(begin, {header.record_bytes, header.record_bytes, header.record_bytes}, header,
               sink);
  return sink.keep();
}

/// After decompression all values of the first field stand first, then those of the second, and so
/// on for every field.
Result<PcdStats> read_compressed(std::string_view body, std::string_view file_name,
                                 const PcdHeader& header, std::vector<Eigen::Vector3f>& points_L) {
  if (header.num_points == 0) return PcdStats{};
  std::array<std::uint32_t, 2> sizes;  // compressed, uncompressed
  if (body.size() < sizeof(sizes)) {
    return fail_at_byte(file_name, header.body_begin + body.size(),
                        "the file ends before the sizes of its compressed body; it is cut off");
  }
  std::memcpy(sizes.data(), body.data(), sizeof(sizes));
  const std::string_view packed = body.substr(sizeof(sizes));
  if (sizes[0] > packed.size()) {
    return fail_at_byte(file_name, header.body_begin + body.size(),
                        "the file ends before the " + std::to_string(sizes[0]) +
                            " bytes of its compressed body do; it is cut off");
  }
  if (sizes[1] % header.record_bytes != 0 || sizes[1] / header.record_bytes != header.num_points) {
    return fail_at_byte(
        file_name, header.body_begin + sizeof(sizes[0]),
        "the uncompressed size does not match the header's points; the file is damaged");
  }
  if (sizes[1] / kMaxExpansion > sizes[0]) {
    return fail_at_byte(file_name, header.body_begin,
                        "the body claims to hold more than it can; the file is damaged");
  }
  const auto unpacked = std::make_unique_for_overwrite<char[]>(sizes[1]);
  if (lzf_decompress(packed.data(), sizes[0], unpacked.get(), sizes[1]) != sizes[1]) {
    return fail_at_byte(file_name, header.body_begin + sizeof(sizes),
                        "the body does not decompress; the file is damaged");
  }
  PointSink sink(points_L, header.num_points);
  std::array<const char*, 3> begin;
  std::array<std::size_t, 3> stride;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    begin[axis] = unpacked.get() + header.xyz[axis].offset * header.num_points;
    stride[axis] = header.xyz[axis].size;
  }
  read_strided(begin, stride, header, sink);
  return sink.keep();
}

/// A coordinate of an ascii cloud; unlike elsewhere, "nan" and "inf" are values and mean no point.
std::optional<float> parse_coordinate(std::string_view field) {
  std::string_view digits = field;
  if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
  for (const std::string_view word : {"nan", "NaN", "NAN", "inf", "Inf", "INF", "-nan(ind)"}) {
    if (digits == word || field == word) return std::numeric_limits<float>::quiet_NaN();
  }
  const auto value = parse_double(field);
  if (!value) return std::nullopt;
  return load_as<double>(reinterpret_cast<const char*>(&*value));
}

Result<PcdStats> read_ascii(std::string_view bytes, std::string_view file_name,
                            const PcdHeader& header, std::vector<Eigen::Vector3f>& points_L) {
  // The shortest line has a digit and a separator for each value.
  const std::size_t max_lines = (bytes.size() - header.body_begin) / 2 + 1;
  PointSink sink(points_L, std::min(header.num_points, max_lines));
  LineReader line(bytes, file_name);
  while (line.line_number() < header.num_lines && line.next_line()) {
  }
  for (std::size_t k = 0; k < header.num_points; ++k) {
    if (!line.next_line()) {
      return line.failure("the file ends after " + std::to_string(k) + " of its " +
                          std::to_string(header.num_points) +
                          " points; it is cut off or its header is wrong");
    }
    Eigen::Vector3f point;
    std::size_t column = 0;
    for (; const auto field = line.next_field(); ++column) {
      for (int axis = 0; axis < 3; ++axis) {
        if (header.xyz[static_cast<std::size_t>(axis)].column != column) continue;
        const auto coordinate = parse_coordinate(*field);
        if (!coordinate) return line.failure("a coordinate is not a number; correct the line");
        point[axis] = *coordinate;
      }
    }
    if (column != header.num_columns) {
      return line.failure("the line has " + std::to_string(column) + " values, the header says " +
                          std::to_string(header.num_columns) + "; correct the line");
    }
    sink.add(point);
  }
  if (line.next_line()) return line.failure("a line follows the last point; correct POINTS");
  return sink.keep();
}

}  // namespace

Result<PcdStats> read_pcd(std::string_view bytes, std::string_view file_name,
                          std::vector<Eigen::Vector3f>& points_L) {
  const auto header = read_pcd_header(bytes, file_name);
  if (!header) return tl::unexpected(header.error());
  const std::string_view body = bytes.substr(header->body_begin);
  switch (header->data) {
    case PcdHeader::Data::kBinary:
      return read_binary(body, file_name, *header, points_L);
    case PcdHeader::Data::kCompressed:
      return read_compressed(body, file_name, *header, points_L);
    default:
      return read_ascii(bytes, file_name, *header, points_L);
  }
}

Result<PcdStats> load_pcd(const std::filesystem::path& path,
                          std::vector<Eigen::Vector3f>& points_L) {
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return read_pcd(*bytes, path.string(), points_L);
}

}  // namespace cloister
