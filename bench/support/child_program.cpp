#include "bench/support/child_program.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include <sys/wait.h>

namespace cloister {

Result<void> run_program(const std::vector<std::string>& words, const std::filesystem::path& out,
                         const std::filesystem::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int kReplace = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kReplace, 0644);
  if (!log.empty())
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), kReplace, 0644);
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    return fail(ErrorKind::kResource, words[0] + ": cannot be started: " + std::strerror(error) +
                                          ": build it, and name its folder with --programs");
  }
  int status = 0;
  const std::string where = log.empty() ? "run it by hand to see why" : "see " + log.string();
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) {
    return fail(ErrorKind::kInterrupted, words[0] + ": was stopped: " + where);
  }
  const int code = WEXITSTATUS(status);
  if (code == 0) return {};
  const bool is_known = code >= static_cast<int>(ErrorKind::kUsage) &&
                        code <= static_cast<int>(ErrorKind::kInterrupted);
  return fail(is_known ? static_cast<ErrorKind>(code) : ErrorKind::kResource,
              words[0] + ": failed with " + std::to_string(code) + ": " + where);
}

std::string source_commit(const std::filesystem::path& tree, const std::filesystem::path& scratch) {
  if (!run_program({"git", "-C", tree.string(), "describe", "--always", "--dirty", "--exclude=*"},
                   scratch / "commit.txt", scratch / "commit.log")) {
    return "unknown";
  }
  std::string commit;
  std::ifstream stream(scratch / "commit.txt");
  std::getline(stream, commit);
  return commit;
}

std::filesystem::path program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace cloister
