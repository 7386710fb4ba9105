#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/core/result.hpp"

namespace cloister {

/// Runs a program to its end, what it prints going to files.
/// @param words  the program's path and its arguments
/// @param out    stdout's file, replaced @param log stderr's file, replaced
/// Errors: kResource when it cannot be started; kInterrupted when it stopped at a signal; else its own status' kind,
/// naming the log
[[nodiscard]] Result<void> run_program(const std::vector<std::string>& words,
                                       const std::filesystem::path& out,
                                       const std::filesystem::path& log);

/// The directory of the running program, where its siblings are.
[[nodiscard]] std::filesystem::path program_folder();

}  // namespace cloister
