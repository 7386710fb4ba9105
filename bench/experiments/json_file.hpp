#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "mapping/core/result.hpp"

namespace cloister {

/// A JSON document whose numbers are asked for by their path, the first missing one being remembered.
class JsonFile {
 public:
  /// Errors: kInput when the file cannot be read or is no JSON
  [[nodiscard]] static Result<JsonFile> open(const std::filesystem::path& path) {
    std::ifstream stream(path);
    if (!stream)
      return fail(ErrorKind::kInput, path.string() + ": cannot be opened: check the path");
    JsonFile file;
    file.path_ = path;
    file.root_ = nlohmann::json::parse(stream, nullptr, false);
    if (file.root_.is_discarded())
      return fail(ErrorKind::kInput, path.string() + ": is no JSON: write it again");
    return file;
  }

  /// @param pointer  as in RFC 6901, "/memory/map_bytes_peak" @return 0 when there is no such number
  template <typename Number>
  [[nodiscard]] Number number(const char* pointer) {
    const nlohmann::json::json_pointer at(pointer);
    if (root_.contains(at) && root_[at].is_number()) return root_[at].get<Number>();
    if (missing_.empty()) missing_ = pointer;
    return Number{};
  }

  /// Errors: kInput naming the first number that was asked for and is not there
  [[nodiscard]] Result<void> is_whole() const {
    if (missing_.empty()) return {};
    return fail(ErrorKind::kInput,
                path_.string() + ": has no number at " + missing_ + ": write it again");
  }

  [[nodiscard]] const nlohmann::json& root() const { return root_; }

 private:
  std::filesystem::path path_;
  nlohmann::json root_;
  std::string missing_;
};

}  // namespace cloister
