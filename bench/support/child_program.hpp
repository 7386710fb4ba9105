#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/core/result.hpp"

namespace cloister {

/// Runs a program to its end, what it prints going to files.
/// @param words  the program's path and its arguments
/// @param out    stdout's file, replaced
/// @param log    stderr's file, replaced; empty: this program's own
/// Errors: kResource when it cannot be started; kInterrupted when it stopped at a signal; else its own status' kind,
/// naming the log
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& words,
                                       const std::filesystem::path& out,
                                       const std::filesystem::path& log);

/// What git calls the tree's commit, "-dirty" behind it where files differ; "unknown" outside of git.
/// @param scratch  folder for what git prints
[[nodiscard]] std::string source_commit(const std::filesystem::path& tree,
                                        const std::filesystem::path& scratch);

/// The directory of the running program, where its siblings are.
[[nodiscard]] std::filesystem::path program_folder();

}  // namespace cloister
