#include "firmware_interface/files/line_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cloister {
namespace {

constexpr double kMaxNormError = 0.01;
constexpr double kMaxTranslation_m = 1e8;
constexpr std::size_t kMaxQuotedField = 40;

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// std::from_chars knows no leading plus sign; some writers put one.
std::string_view without_plus(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  return field;
}

/// The field as it may stand in a one-line message: shortened, and without control characters.
std::string quoted(std::string_view field) {
  std::string text = "'";
  for (const char c : field.substr(0, kMaxQuotedField)) {
    text += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return text + (field.size() > kMaxQuotedField ? "...'" : "'");
}

}  // namespace

std::optional<double> parse_double(std::string_view field) {
  field = without_plus(field);
  double value = 0;
  const char* const end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    const bool tiny = field.find("e-") != field.npos || field.find("E-") != field.npos;
    return tiny ? std::optional<double>(0.0) : std::nullopt;
  }
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

std::optional<std::int64_t> parse_int(std::string_view field) {
  field = without_plus(field);
  std::int64_t value = 0;
  const char* const end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (stop != end || error != std::errc()) return std::nullopt;
  return value;
}

std::optional<SensorTime> parse_stamp(std::string_view field) {
  field = without_plus(field);
  const bool negative = !field.empty() && field[0] == '-';
  if (negative) field.remove_prefix(1);

  // value = digits * 10^exponent seconds; leading zeros do not count as digits.
  std::int64_t exponent = 0;
  if (const auto e = field.find_first_of("eE"); e != field.npos) {
    const auto written = parse_int(field.substr(e + 1));
    if (!written || std::abs(*written) > 1000) return std::nullopt;
    exponent = *written;
    field = field.substr(0, e);
  }
  const auto point = field.find('.');
  const std::string_view whole = field.substr(0, point);
  const std::string_view fraction = point == field.npos ? "" : field.substr(point + 1);
  if (whole.empty() && fraction.empty()) return std::nullopt;
  if (!std::ranges::all_of(whole, is_digit) || !std::ranges::all_of(fraction, is_digit)) {
    return std::nullopt;
  }

  // Digit k of whole + fraction, from the left, is worth 10^(whole.size() - 1 - k + exponent) s:
  // take those worth a nanosecond or more, append zeros down to the nanosecond, and round by the
  // first digit below.
  const auto digit_at = [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (i < whole.size()) return whole[i] - '0';
    return i - whole.size() < fraction.size() ? fraction[i - whole.size()] - '0' : 0;
  };
  const std::int64_t num_taken = static_cast<std::int64_t>(whole.size()) + exponent + 9;
  std::int64_t ns = 0;
  for (std::int64_t k = 0; k < num_taken; ++k) {
    if (ns > kMaxStamp_ns / 10) return std::nullopt;
    ns = 10 * ns + digit_at(k);
  }
  if (num_taken >= 0 && digit_at(num_taken) >= 5) ++ns;
  if (ns > kMaxStamp_ns) return std::nullopt;
  return SensorTime{negative ? -ns : ns};
}

std::optional<SensorTime> make_stamp(std::int64_t seconds, std::int64_t nanoseconds) {
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  if (seconds < 0 || seconds >= kMaxStamp_ns / kNanosecondsPerSecond || nanoseconds < 0 ||
      nanoseconds >= kNanosecondsPerSecond) {
    return std::nullopt;
  }
  return SensorTime{seconds * kNanosecondsPerSecond + nanoseconds};
}

LineReader::LineReader(std::string_view text, std::string_view file_name, Separator separator)
    : text_(text), file_name_(file_name), separator_(separator) {
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
}

bool LineReader::next_line() {
  while (!text_.empty()) {
    const auto end = text_.find('\n');
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == text_.npos ? text_.size() : end + 1);
    ++line_number_;

    const auto comment = line.find('#');
    line_ = trimmed(line.substr(0, comment));
    if (!line_.empty()) {
      rewind_line();
      return true;
    }
    if (comment != line.npos) ++num_comment_lines_;
  }
  line_ = {};
  rewind_line();
  return false;
}

void LineReader::rewind_line() {
  rest_ = line_;
  has_more_ = !line_.empty();
  num_fields_ = 0;
}

std::optional<std::string_view> LineReader::next_field() {
  if (!has_more_) return std::nullopt;
  ++num_fields_;
  if (separator_ == Separator::kCommas) {
    const auto comma = rest_.find(',');
    const std::string_view field = trimmed(rest_.substr(0, comma));
    has_more_ = comma != rest_.npos;
    rest_.remove_prefix(has_more_ ? comma + 1 : rest_.size());
    return field;
  }
  // `rest_` starts at a field, and ends in none but fields, since lines are trimmed.
  std::size_t end = 0;
  while (end < rest_.size() && !is_blank(rest_[end])) ++end;
  const std::string_view field = rest_.substr(0, end);
  while (end < rest_.size() && is_blank(rest_[end])) ++end;
  rest_.remove_prefix(end);
  has_more_ = !rest_.empty();
  return field;
}

bool LineReader::refuse_field(std::optional<std::string_view> field, std::string_view wanted) {
  if (!field) {
    problem_ = "the line ends after " + std::to_string(num_fields_) + " fields, where " +
               std::string(wanted) + " should follow; complete or remove the line";
  } else {
    problem_ = "field " + std::to_string(num_fields_) + ", " + quoted(*field) + ", is not " +
               std::string(wanted) + "; correct or remove the line";
  }
  return false;
}

bool LineReader::read(double& value) {
  const auto field = next_field();
  const auto parsed = field ? parse_double(*field) : std::nullopt;
  if (!parsed) return refuse_field(field, "a finite number");
  value = *parsed;
  return true;
}

bool LineReader::read(std::span<double> values) {
  return std::ranges::all_of(values, [this](double& value) { return read(value); });
}

bool LineReader::read(std::int64_t& value) {
  const auto field = next_field();
  const auto parsed = field ? parse_int(*field) : std::nullopt;
  if (!parsed) return refuse_field(field, "an integer");
  value = *parsed;
  return true;
}

bool LineReader::read(SensorTime& stamp) {
  const auto field = next_field();
  const auto parsed = field ? parse_stamp(*field) : std::nullopt;
  if (!parsed) return refuse_field(field, "a stamp in seconds");
  stamp = *parsed;
  return true;
}

bool LineReader::read(Pose& T_A_B) {
  double v[7];
  if (!read(std::span<double>(v))) return false;
  const Eigen::Vector3d t_A_B(v[0], v[1], v[2]);
  if (t_A_B.cwiseAbs().maxCoeff() > kMaxTranslation_m) {
    problem_ = "a position lies more than 1e8 m from the origin; correct or remove the line";
    return false;
  }
  const Eigen::Quaterniond q_A_B(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q_A_B.norm() - 1.0) <= kMaxNormError)) {
    problem_ = "a quaternion has length " + std::to_string(q_A_B.norm()) +
               ", which is not 1; write unit quaternions as qx qy qz qw";
    return false;
  }
  T_A_B = make_pose(t_A_B, q_A_B);
  return true;
}

bool LineReader::read_end() {
  if (at_line_end()) return true;
  const auto field = next_field();
  problem_ = "the line should end before field " + std::to_string(num_fields_) + ", " +
             quoted(*field) + "; remove what is too much";
  return false;
}

tl::unexpected<Error> LineReader::failure(std::string_view problem) const {
  return failure_at(line_number_, problem);
}

tl::unexpected<Error> LineReader::failure_at(std::size_t line_number,
                                             std::string_view problem) const {
  return fail(ErrorKind::kInput, std::string(file_name_) + ":" + std::to_string(line_number) +
                                     ": " + std::string(problem));
}

}  // namespace cloister
