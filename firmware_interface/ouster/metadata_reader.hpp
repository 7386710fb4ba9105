#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// The line, counted from 1, that holds a byte of a text.
[[nodiscard]] int line_of_byte(std::string_view text, std::size_t byte);

/// Reads the fields of a metadata file one by one and remembers the first that is wrong; every read
/// after that is harmless.
///
/// A field is looked for in several sections, since the forms keep it in different places; "" is
/// the top level. A field that is absent or null is nothing, or an empty list.
class MetadataReader {
 public:
  using Sections = std::initializer_list<const char*>;

  /// All three must outlive the reader.
  MetadataReader(const nlohmann::json& root, std::string_view text, std::string_view file_name)
      : root_(root), text_(text), file_name_(file_name) {}

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  /// Notes that a field is wrong, as "file:line: key[index] what", unless one was wrong before.
  void refuse(std::string_view key, const std::string& what, const std::string& index = "");

  [[nodiscard]] bool has(std::string_view key, Sections sections) const {
    return find(key, sections) != nullptr;
  }
  std::optional<std::string> string(std::string_view key, Sections sections);
  std::optional<double> number(std::string_view key, Sections sections, double max_magnitude);
  std::vector<double> numbers(std::string_view key, Sections sections, double max_magnitude);
  std::optional<int> integer(std::string_view key, Sections sections, int min, int max);
  std::vector<int> integers(std::string_view key, Sections sections, int min, int max);

  /// A rigid 4x4 transform, row-major with its shift in millimetres, as one in metres.
  std::optional<Pose> transform(std::string_view key, Sections sections);

 private:
  const nlohmann::json* find(std::string_view key, Sections sections) const;
  template <typename Visit>
  void for_each(std::string_view key, Sections sections, Visit visit);
  std::optional<double> to_number(const nlohmann::json& value, std::string_view key,
                                  const std::string& index, double max_magnitude);
  std::optional<int> to_integer(const nlohmann::json& value, std::string_view key,
                                const std::string& index, int min, int max);

  const nlohmann::json& root_;
  std::string_view text_;
  std::string_view file_name_;
  std::optional<Error> error_;
};

}  // namespace cloister
