#include "bench/integration/truth_points.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstring>
#include <string>

#include <sys/wait.h>

namespace cloister {
namespace {

/// Runs a program to its end. @return what it wrote to stdout
Result<std::string> output_of(const std::vector<std::string>& words) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    return fail(ErrorKind::kResource, std::string("no pipe: ") + std::strerror(errno));
  }
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t child = 0;
  const int error =
      posix_spawn(&child, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text;
  std::array<char, 65536> buffer;
  ssize_t count = 0;
  while (error == 0 && (count = read(ends[0], buffer.data(), buffer.size())) > 0) {
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(ends[0]);
  if (error != 0) {
    return fail(ErrorKind::kResource, words[0] + ": cannot be started: " + std::strerror(error) +
                                          ": build it beside this program");
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return fail(ErrorKind::kResource, words[0] + ": failed: run it by hand to see why");
  }
  return text;
}

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
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto text = output_of({(self.parent_path() / "cloister-bench-true-points").string(),
                               mission.string(), "--points", std::to_string(count)});
  if (!text) return tl::unexpected(text.error());
  return parse_truth_points(*text);
}

}  // namespace cloister
