#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace cloister {

/// Text for people: pages and pictures, as opposed to files that are read back.

/// At most `decimals` decimals, without zeros at the end: "12.5"; a dash for what is not finite.
[[nodiscard]] std::string compact(double value, int decimals = 2);

/// Exactly `decimals` decimals: "12.50"; a dash for what is not finite.
[[nodiscard]] std::string fixed(double value, int decimals);

/// Three meaningful digits, with thousands set apart: "1,234", "12.0", "0.0123".
[[nodiscard]] std::string readable(double value);

/// Thousands set apart by commas: "1,234,567".
[[nodiscard]] std::string grouped(std::int64_t value);

/// "12.3 MB" (10^6 bytes), or GB, kB.
[[nodiscard]] std::string byte_size(std::int64_t bytes);

/// Elapsed time as "m:ss", or "h:mm:ss"; with `decimals` of the second if asked.
[[nodiscard]] std::string clock_text(double seconds, int decimals = 0);

/// For XML text and double-quoted attributes: escapes markup, replaces control characters and bytes
/// that are not UTF-8.
[[nodiscard]] std::string escape_xml(std::string_view text);

/// Appends pieces one after another; a floating-point number gets at most two decimals, as
/// coordinates in a drawing need.
template <typename... Pieces>
void put(std::string& out, const Pieces&... pieces) {
  const auto one = [&out](const auto& piece) {
    using Piece = std::decay_t<decltype(piece)>;
    if constexpr (std::floating_point<Piece>) {
      out += compact(piece);
    } else if constexpr (std::integral<Piece> && !std::same_as<Piece, char>) {
      out += std::to_string(piece);
    } else {
      out += piece;
    }
  };
  (one(pieces), ...);
}

}  // namespace cloister
