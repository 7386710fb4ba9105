#include "firmware_interface/files/csv_file.hpp"

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>

#include "firmware_interface/files/line_reader.hpp"
#include "firmware_interface/files/read_file.hpp"

namespace cloister {
namespace {

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](char x, char y) { return (x >= 'A' && x <= 'Z' ? x - 'A' + 'a' : x) == y; });
}

/// True when the line's fields are exactly these names, which are lower-case, in any case.
/// Leaves the line at its first field.
bool is_header(LineReader& line, std::initializer_list<std::string_view> names) {
  const bool same = std::ranges::all_of(names, [&line](std::string_view name) {
    const auto field = line.next_field();
    return field && equal_ignoring_case(*field, name);
  });
  const bool whole = line.at_line_end();
  line.rewind_line();
  return same && whole;
}

/// Reads rows through `read_row(line, row)` after an optional header.
template <typename Row, typename ReadRow>
Result<std::vector<Row>> read_rows(std::string_view text, std::string_view file_name,
                                   std::initializer_list<std::string_view> names,
                                   ReadRow&& read_row) {
  std::vector<Row> rows;
  LineReader line(text, file_name, LineReader::Separator::kCommas);
  for (bool first = true; line.next_line(); first = false) {
    if (first && is_header(line, names)) continue;
    if (!read_row(line, rows.emplace_back()) || !line.read_end()) return line.failure();
  }
  return rows;
}

}  // namespace

Result<std::vector<Eigen::Vector3d>> read_points_csv(std::string_view text,
                                                     std::string_view file_name) {
  return read_rows<Eigen::Vector3d>(text, file_name, {"x", "y", "z"},
                                    [](LineReader& line, Eigen::Vector3d& point_M) {
                                      return line.read(std::span<double>(point_M.data(), 3));
                                    });
}

Result<std::vector<NodePair>> read_pairs_csv(std::string_view text, std::string_view file_name) {
  return read_rows<NodePair>(text, file_name, {"i", "j"}, [](LineReader& line, NodePair& pair) {
    return line.read(pair.first) && line.read(pair.second);
  });
}

Result<std::vector<Eigen::Vector3d>> load_points_csv(const std::filesystem::path& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  return read_points_csv(*text, path.string());
}

Result<std::vector<NodePair>> load_pairs_csv(const std::filesystem::path& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  return read_pairs_csv(*text, path.string());
}

}  // namespace cloister
