#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cloister {

/// An HTTP/1.1 response as far as one small request needs it (RFC 9112): fed with all bytes received so far.
struct HttpResponse {
  int status = 0;
  std::string body;
};

enum class HttpProgress { kIncomplete, kComplete, kMalformed };

/// Reads a response whose body is announced by `Content-Length`, sent in chunks, or ended by the connection's end.
/// @param bytes     everything received on the connection
/// @param is_ended  the other side has closed it
/// @param response  filled when complete
[[nodiscard]] HttpProgress read_http_response(std::string_view bytes, bool is_ended,
                                              HttpResponse& response);

}  // namespace cloister
