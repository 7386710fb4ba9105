#include "bench/integration/truth_points.hpp"

#include <stdlib.h>

#include <array>
#include <charconv>
#include <string>

#include "bench/support/child_program.hpp"
#include "firmware_interface/files/read_file.hpp"

namespace cloister {
namespace {

/// A folder for the time that something is asked of another program.
struct Scratch {
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "cloister-truth-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) folder = name;
  }
  ~Scratch() {
    std::error_code ignored;
    if (!folder.empty()) std::filesystem::remove_all(folder, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::filesystem::path folder;  ///< empty when it could not be made
};

/// Reads "x,y,z,solid" of one line.
bool parse_row(std::string_view line, TruthPoint& point) {
  std::array<double, 4> cells{};
  const char* at = line.data();
  const char* const end = line.data() + line.size();
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const auto [next, error] = std::from_chars(at, end, cells[k]);
    const bool is_ended = k + 1 < cells.size() ? next != end && *next == ',' : next == end;
    if (error != std::errc{} || !is_ended) return false;
    at = next + 1;
  }
  point = {{cells[0], cells[1], cells[2]}, cells[3] == 1};
  return cells[3] == 0 || cells[3] == 1;
}

}  // namespace

Result<std::vector<TruthPoint>> parse_truth_points(std::string_view text) {
  std::vector<TruthPoint> points;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (number == 1) continue;  // the header
    if (!parse_row(line, points.emplace_back())) {
      return fail(ErrorKind::kInput,
                  "truth points: line " + std::to_string(number) + ": expected x,y,z and 0 or 1");
    }
  }
  return points;
}

Result<std::vector<TruthPoint>> draw_truth_points(const std::filesystem::path& mission,
                                                  std::size_t count) {
  const Scratch scratch;
  if (scratch.folder.empty()) {
    return fail(ErrorKind::kResource,
                "no folder for truth points: free some room in the temporary folder");
  }
  const std::filesystem::path drawn = scratch.folder / "points.csv";
  const auto run = run_program({(program_folder() / "cloister-bench-true-points").string(),
                                mission.string(), "--points", std::to_string(count)},
                               drawn, {});
  if (!run) return tl::unexpected(run.error());
  const auto text = read_file(drawn);
  if (!text) return tl::unexpected(text.error());
  return parse_truth_points(*text);
}

}  // namespace cloister
