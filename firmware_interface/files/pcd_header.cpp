#include "firmware_interface/files/pcd_header.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware_interface/files/line_reader.hpp"

namespace cloister {
namespace {

/// Points of a cloud larger than this are a damaged header.
constexpr std::int64_t kMaxPoints = std::int64_t{1} << 40;

/// The header's lines as written, before they are held against each other.
struct HeaderLines {
  std::vector<std::string_view> names;
  std::vector<std::int64_t> sizes;
  std::vector<char> types;
  std::vector<std::int64_t> counts;
  std::optional<std::int64_t> width, height, points;
};

bool is_size(std::int64_t size) { return size == 1 || size == 2 || size == 4 || size == 8; }

/// Reads one line other than DATA. Returns what is wrong with it, or nothing.
std::optional<Error> read_header_line(std::string_view key, LineReader& line, HeaderLines& header) {
  const auto read_number = [&](std::optional<std::int64_t>& number) -> std::optional<Error> {
    std::int64_t value = 0;
    if (!line.read(value) || !line.read_end()) return line.failure().value();
    if (value < 0 || value > kMaxPoints) return line.failure("the number is out of range").value();
    number = value;
    return std::nullopt;
  };
  if (key == "FIELDS") {
    while (const auto name = line.next_field()) header.names.push_back(*name);
  } else if (key == "SIZE") {
    while (!line.at_line_end()) {
      if (!line.read(header.sizes.emplace_back())) return line.failure().value();
      if (!is_size(header.sizes.back())) {
        return line.failure("a SIZE is none of 1, 2, 4, 8; correct it").value();
      }
    }
  } else if (key == "TYPE") {
    while (const auto type = line.next_field()) {
      if (*type != "I" && *type != "U" && *type != "F") {
        return line.failure("a TYPE is none of I, U, F; correct it").value();
      }
      header.types.push_back(type->front());
    }
  } else if (key == "COUNT") {
    while (!line.at_line_end()) {
      std::int64_t& count = header.counts.emplace_back();
      if (!line.read(count)) return line.failure().value();
      if (count < 1 || count > static_cast<std::int64_t>(kMaxPcdRecordBytes)) {
        return line.failure("a COUNT is not between 1 and 1048576; correct it").value();
      }
    }
  } else if (key == "WIDTH") {
    return read_number(header.width);
  } else if (key == "HEIGHT") {
    return read_number(header.height);
  } else if (key == "POINTS") {
    return read_number(header.points);
  } else if (key != "VERSION" && key != "VIEWPOINT") {
    return line.failure("the line is none of a PCD header's; is this a PCD v0.7 file?").value();
  }
  return std::nullopt;
}

/// Lays out the fields of a record and counts the points. Returns what does not fit, or nothing.
std::optional<std::string> lay_out(const HeaderLines& lines, PcdHeader& header) {
  const std::size_t num_fields = lines.names.size();
  if (lines.sizes.size() != num_fields || lines.types.size() != num_fields ||
      (!lines.counts.empty() && lines.counts.size() != num_fields)) {
    return "FIELDS, SIZE, TYPE and COUNT do not have one entry for each field; complete them";
  }
  std::array<bool, 3> found = {};
  for (std::size_t k = 0; k < num_fields; ++k) {
    const auto size = static_cast<std::size_t>(lines.sizes[k]);
    const auto count = lines.counts.empty() ? 1 : static_cast<std::size_t>(lines.counts[k]);
    const std::size_t axis = lines.names[k].size() == 1
                                 ? std::string_view("xyz").find(lines.names[k])
                                 : std::string_view::npos;
    if (axis != std::string_view::npos) {
      if (found[axis] || count != 1) return "x, y and z must be there once, with COUNT 1";
      if (lines.types[k] == 'F' && size < 4) return "a coordinate of TYPE F has a SIZE below 4";
      found[axis] = true;
      header.xyz[axis] = {lines.types[k], size, header.record_bytes, header.num_columns};
    }
    header.record_bytes += size * count;
    header.num_columns += count;
    if (header.record_bytes > kMaxPcdRecordBytes) return "a point takes more than 1 MiB";
  }
  if (!found[0] || !found[1] || !found[2]) return "FIELDS does not name x, y and z; add them";

  if (!lines.width && !lines.points) return "neither WIDTH nor POINTS is given; add them";
  const std::int64_t height = lines.height.value_or(1);
  std::int64_t product = 0;
  if (lines.width &&
      (__builtin_mul_overflow(*lines.width, height, &product) || product > kMaxPoints)) {
    return "WIDTH times HEIGHT is out of range";
  }
  if (lines.width && lines.points && product != *lines.points) {
    return "POINTS is not WIDTH times HEIGHT; correct one of them";
  }
  header.num_points = static_cast<std::size_t>(lines.points.value_or(product));
  return std::nullopt;
}

}  // namespace

Result<PcdHeader> read_pcd_header(std::string_view bytes, std::string_view file_name) {
  LineReader line(bytes, file_name);
  HeaderLines lines;
  while (line.next_line()) {
    const std::string_view key = *line.next_field();
    if (key != "DATA") {
      if (auto error = read_header_line(key, line, lines)) return tl::unexpected(std::move(*error));
      continue;
    }
    PcdHeader header;
    const std::string_view data = line.next_field().value_or("");
    if (data == "ascii") {
      header.data = PcdHeader::Data::kAscii;
    } else if (data == "binary") {
      header.data = PcdHeader::Data::kBinary;
    } else if (data == "binary_compressed") {
      header.data = PcdHeader::Data::kCompressed;
    } else {
      return line.failure("DATA is none of ascii, binary, binary_compressed; convert the cloud");
    }
    if (!line.read_end()) return line.failure();
    if (const auto problem = lay_out(lines, header)) return line.failure("header: " + *problem);
    header.body_begin = bytes.size() - line.remaining_text().size();
    header.num_lines = line.line_number();
    return header;
  }
  return line.failure("the header ends without a DATA line; is this a PCD v0.7 file?");
}

}  // namespace cloister
