#include "firmware_interface/output/page_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace cloister {
namespace {

constexpr std::string_view kNone = "–";

// Bytes of the UTF-8 sequence that begins the text, 0 when it is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  const std::size_t length = lead < 0x80                   ? 1
                             : lead >= 0xC2 && lead < 0xE0 ? 2
                             : lead >= 0xE0 && lead < 0xF0 ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if (length > 2) {  // overlong forms, surrogates and what lies beyond U+10FFFF
    const unsigned char second = byte(1);
    if (lead == 0xE0 && second < 0xA0) return 0;
    if (lead == 0xED && second > 0x9F) return 0;
    if (lead == 0xF0 && second < 0x90) return 0;
    if (lead == 0xF4 && second > 0x8F) return 0;
  }
  return length;
}

}  // namespace

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return std::string(kNone);
  if (std::abs(value) > 1e15) decimals = 0;
  std::array<char, 400> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  return {buffer.data(), end};
}

std::string compact(double value, int decimals) {
  std::string text = fixed(value, decimals);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string readable(double value) {
  if (!std::isfinite(value)) return std::string(kNone);
  const double magnitude = std::abs(value);
  if (magnitude == 0) return "0";
  if (magnitude >= 999.5) return magnitude < 1e15 ? grouped(std::llround(value)) : fixed(value, 0);
  const int decimals = 2 - static_cast<int>(std::floor(std::log10(magnitude)));
  return fixed(value, std::clamp(decimals, 0, 6));
}

std::string grouped(std::int64_t value) {
  std::string text = std::to_string(value);
  const std::size_t first = value < 0 ? 1 : 0;
  for (std::size_t i = text.size(); i > first + 3;) text.insert(i -= 3, 1, ',');
  return text;
}

std::string byte_size(std::int64_t bytes) {
  const auto amount = static_cast<double>(bytes);
  if (amount >= 999.5e6) return readable(amount * 1e-9) + " GB";
  if (amount >= 999.5e3) return readable(amount * 1e-6) + " MB";
  return readable(amount * 1e-3) + " kB";
}

std::string clock_text(double seconds, int decimals) {
  if (!(std::abs(seconds) < 1e12)) return std::string(kNone);
  const auto ticks_per_s = std::llround(std::pow(10.0, decimals));
  const std::int64_t ticks = std::llround(std::abs(seconds) * static_cast<double>(ticks_per_s));
  const std::int64_t minutes = ticks / (60 * ticks_per_s);
  const double rest_s =
      static_cast<double>(ticks % (60 * ticks_per_s)) / static_cast<double>(ticks_per_s);
  std::string text = seconds < 0 ? "-" : "";
  if (minutes >= 60) text += std::to_string(minutes / 60) + (minutes % 60 < 10 ? ":0" : ":");
  text += std::to_string(minutes % 60) + (rest_s < 10 ? ":0" : ":");
  return text + fixed(rest_s, decimals);
}

std::string escape_xml(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char first = text.front();
    if (length == 0 || (length == 1 && static_cast<unsigned char>(first) < 0x20)) {
      out += length == 0 ? "\xEF\xBF\xBD" : " ";
      text.remove_prefix(1);
      continue;
    }
    if (first == '&')
      out += "&amp;";
    else if (first == '<')
      out += "&lt;";
    else if (first == '>')
      out += "&gt;";
    else if (first == '"')
      out += "&quot;";
    else
      out += text.substr(0, length);
    text.remove_prefix(length);
  }
  return out;
}

}  // namespace cloister
