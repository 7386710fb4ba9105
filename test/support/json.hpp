#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "test/support/program.hpp"

namespace cloister {

inline nlohmann::json read_json(const std::filesystem::path& path) {
  return nlohmann::json::parse(read_text(path));
}

}  // namespace cloister
