#pragma once

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

namespace cloister {

/// Appends the shortest text that reads back to the same double.
inline void append_number(double value, std::string* text) {
  char buffer[40];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text->append(buffer, result.ptr);
}

/// The words of a line, up to a `#`; blanks and `separators` part them.
inline std::vector<std::string_view> split_words(std::string_view line,
                                                 std::string_view separators = " \t\r") {
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(separators, at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// True when the whole word is a number.
inline bool parse_number(std::string_view word, double* value) {
  const auto result = std::from_chars(word.data(), word.data() + word.size(), *value);
  return result.ec == std::errc{} && result.ptr == word.data() + word.size();
}

}  // namespace cloister
