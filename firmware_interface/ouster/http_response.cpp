#include "firmware_interface/ouster/http_response.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace cloister {
namespace {

constexpr std::string_view kLineEnd = "\r\n";

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::optional<std::size_t> number(std::string_view text, int base) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end == text.data()) return std::nullopt;
  return value;
}

HttpProgress read_chunks(std::string_view bytes, std::string& body) {
  while (true) {
    const std::size_t line_end = bytes.find(kLineEnd);
    if (line_end == std::string_view::npos) return HttpProgress::kIncomplete;
    const auto size = number(bytes.substr(0, line_end), 16);
    if (!size) return HttpProgress::kMalformed;
    if (*size == 0) return HttpProgress::kComplete;
    bytes.remove_prefix(line_end + kLineEnd.size());
    if (bytes.size() < *size || bytes.size() - *size < kLineEnd.size())
      return HttpProgress::kIncomplete;
    if (bytes.substr(*size, kLineEnd.size()) != kLineEnd) return HttpProgress::kMalformed;
    body.append(bytes.substr(0, *size));
    bytes.remove_prefix(*size + kLineEnd.size());
  }
}

}  // namespace

HttpProgress read_http_response(std::string_view bytes, bool is_ended, HttpResponse& response) {
  const HttpProgress unfinished = is_ended ? HttpProgress::kMalformed : HttpProgress::kIncomplete;
  constexpr std::string_view kHeadEnd = "\r\n\r\n";
  const std::size_t head_end = bytes.find(kHeadEnd);
  if (head_end == std::string_view::npos) return unfinished;
  std::string_view head = bytes.substr(0, head_end + kLineEnd.size());
  const std::string_view rest = bytes.substr(head_end + kHeadEnd.size());

  // "HTTP/1.1 200 OK"
  if (!head.starts_with("HTTP/1.") || head.size() < 12 || head[8] != ' ')
    return HttpProgress::kMalformed;
  const auto status = number(head.substr(9, 3), 10);
  if (!status) return HttpProgress::kMalformed;

  std::optional<std::size_t> length;
  bool is_chunked = false;
  for (head.remove_prefix(head.find(kLineEnd) + kLineEnd.size()); !head.empty();) {
    const std::size_t line_end = head.find(kLineEnd);
    const std::string_view line = head.substr(0, line_end);
    head.remove_prefix(line_end + kLineEnd.size());
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return HttpProgress::kMalformed;
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (equal_ignoring_case(name, "content-length") && !(length = number(value, 10)))
      return HttpProgress::kMalformed;
    if (equal_ignoring_case(name, "transfer-encoding"))
      is_chunked = equal_ignoring_case(value, "chunked");
  }

  HttpResponse read{static_cast<int>(*status), {}};
  if (is_chunked) {
    const HttpProgress progress = read_chunks(rest, read.body);
    if (progress != HttpProgress::kComplete)
      return progress == HttpProgress::kIncomplete ? unfinished : progress;
  } else if (length) {
    if (rest.size() < *length) return unfinished;
    read.body = rest.substr(0, *length);
  } else {
    if (!is_ended) return HttpProgress::kIncomplete;
    read.body = rest;
  }
  response = std::move(read);
  return HttpProgress::kComplete;
}

}  // namespace cloister
