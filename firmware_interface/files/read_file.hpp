#pragma once

#include <filesystem>
#include <string>

#include "mapping/core/result.hpp"

namespace cloister {

/// All bytes of a regular file. Fails with kInput, naming the path, when it is missing, is no file
/// or cannot be read, and with kResource when it does not fit into memory.
[[nodiscard]] Result<std::string> read_file(const std::filesystem::path& path);

}  // namespace cloister
