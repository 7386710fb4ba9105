#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace cloister {

/// What kind of failure reached a boundary. The values are the program's exit statuses.
enum class ErrorKind {
  kUsage = 2,        ///< the command line or the configuration is wrong
  kInput = 3,        ///< an input is missing or malformed
  kResource = 4,     ///< memory, disk or a peer is missing
  kInterrupted = 5,  ///< stopped from outside; what was written is complete up to there
};

/// One failure: its kind, and one line that says what, where (file, byte or line) and what to do.
struct Error {
  ErrorKind kind = ErrorKind::kInput;
  std::string message;
};

/// A value or the failure that kept it from being made. Boundaries only: never on the hot path.
template <typename T>
using Result = tl::expected<T, Error>;

/// Shorthand for `return fail(ErrorKind::kInput, "...")`.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorKind kind, std::string message) {
  return tl::unexpected<Error>(Error{kind, std::move(message)});
}

}  // namespace cloister
