#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <string>

#include "mapping/core/time.hpp"

namespace cloister {

/// Appends a number so that it reads back to the same value: for floating point the shortest such
/// text, independent of the locale ("0.1", "1e-07", "nan", "inf").
template <typename Number>
requires std::integral<Number> || std::floating_point<Number>
void append_number(std::string& text, Number value) {
  char buffer[40];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
}

/// Appends a stamp as decimal seconds with nine decimals, exactly.
inline void append_stamp(std::string& text, SensorTime stamp) {
  // Unsigned, so that the smallest stamp has a magnitude too.
  const std::uint64_t magnitude = stamp.ns < 0 ? 0 - static_cast<std::uint64_t>(stamp.ns)
                                               : static_cast<std::uint64_t>(stamp.ns);
  if (stamp.ns < 0) text += '-';
  append_number(text, magnitude / 1'000'000'000);
  const std::string nanoseconds = std::to_string(1'000'000'000 + magnitude % 1'000'000'000);
  text += '.';
  text.append(nanoseconds, 1);
}

}  // namespace cloister
