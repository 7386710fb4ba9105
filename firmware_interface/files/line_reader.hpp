#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mapping/core/pose.hpp"
#include "mapping/core/result.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// Stamps further from zero than this (the year 2096) are refused everywhere,
/// so that two of them can be subtracted.
inline constexpr std::int64_t kMaxStamp_ns = 4'000'000'000'000'000'000;

/// A whole field as a finite number, independent of the locale, or nothing.
/// Too small for a double reads as zero.
[[nodiscard]] std::optional<double> parse_double(std::string_view field);

/// A whole field as an integer, or nothing.
[[nodiscard]] std::optional<std::int64_t> parse_int(std::string_view field);

/// A decimal count of seconds ("1630577758.46949", "1.63e+09") as exact nanoseconds: digits never
/// pass through a double, which at Unix time is 238 ns coarse. Digits beyond the ninth decimal are
/// rounded half away from zero.
[[nodiscard]] std::optional<SensorTime> parse_stamp(std::string_view field);

/// Whole seconds and the nanoseconds beyond them (0 to 999,999,999) as one stamp,
/// or nothing when out of range.
[[nodiscard]] std::optional<SensorTime> make_stamp(std::int64_t seconds, std::int64_t nanoseconds);

/// Walks a text line by line and field by field, and knows where it stands when something is wrong.
///
/// Blank lines are passed over, `#` starts a comment that runs to the end of its line, lines end in
/// LF or CRLF, and a byte-order mark at the start is skipped. Reading stops being useful at the
/// first failed `read`: the caller returns `failure()`, whose message begins with "file:line: ".
/// Allocates only for such a message.
class LineReader {
 public:
  enum class Separator { kBlanks, kCommas };

  /// @param text, file_name outlive the reader; the name serves messages only
  LineReader(std::string_view text, std::string_view file_name,
             Separator separator = Separator::kBlanks);

  /// Moves to the next line that holds a field; false at the end of the text.
  [[nodiscard]] bool next_line();

  /// The next field of this line, or nothing when none is left.
  /// Between two commas a field may be empty.
  std::optional<std::string_view> next_field();

  /// True when this line holds no further field.
  [[nodiscard]] bool at_line_end() const { return !has_more_; }

  /// Goes back to the first field of this line.
  void rewind_line();

  [[nodiscard]] bool read(double& value);
  [[nodiscard]] bool read(std::span<double> values);
  [[nodiscard]] bool read(std::int64_t& value);
  [[nodiscard]] bool read(SensorTime& stamp);
  /// Reads `x y z qx qy qz qw`. The quaternion may be off unit length by 1 % and is normalised;
  /// beyond that, or with a translation of more than 10^8 m, the line is refused.
  [[nodiscard]] bool read(Pose& T_A_B);
  /// Fails when the line goes on.
  [[nodiscard]] bool read_end();

  /// What follows this line.
  [[nodiscard]] std::string_view remaining_text() const { return text_; }
  /// Line number, from 1.
  [[nodiscard]] std::size_t line_number() const { return line_number_; }
  /// Lines passed so far that held nothing but a comment.
  [[nodiscard]] std::size_t num_comment_lines() const { return num_comment_lines_; }

  /// The failure of the last `read` that returned false.
  [[nodiscard]] tl::unexpected<Error> failure() const { return failure(problem_); }
  /// A failure of this line that the caller found.
  [[nodiscard]] tl::unexpected<Error> failure(std::string_view problem) const;
  /// A failure of another line that the caller found.
  [[nodiscard]] tl::unexpected<Error> failure_at(std::size_t line_number,
                                                 std::string_view problem) const;

 private:
  bool refuse_field(std::optional<std::string_view> field, std::string_view wanted);

  std::string_view text_;  ///< what follows the current line
  std::string_view file_name_;
  Separator separator_;
  std::string_view line_;  ///< the current line without its comment
  std::string_view rest_;  ///< what follows the current field
  bool has_more_ = false;
  std::size_t line_number_ = 0;
  std::size_t num_comment_lines_ = 0;
  int num_fields_ = 0;  ///< fields taken from this line
  std::string problem_;
};

}  // namespace cloister
