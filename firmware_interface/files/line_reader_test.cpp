#include "firmware_interface/files/line_reader.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include "firmware_interface/files/test_files.hpp"
#include "firmware_interface/files/text_format.hpp"

namespace cloister {
namespace {

TEST_CASE("numbers are read whole, finite and without regard to the locale") {
  CHECK(parse_double("-1.5e3") == -1500.0);
  CHECK(parse_double("+2.5") == 2.5);
  CHECK(parse_double(".5") == 0.5);
  CHECK(parse_double("1e-400") == 0.0);
  for (const char* text :
       {"", "+", "+-1", "1,5", "1.5x", "nan", "inf", "-inf", "1e999", "0x10", "1 "}) {
    CAPTURE(text);
    CHECK_FALSE(parse_double(text));
  }
  CHECK(parse_int("-7") == -7);
  CHECK_FALSE(parse_int("7.0"));
  CHECK_FALSE(parse_int("9223372036854775808"));
}

TEST_CASE("stamps are read exactly to the nanosecond") {
  struct Row {
    const char* text;
    std::int64_t ns;
  };
  for (const Row& row : {Row{"1630577758.469490000", 1630577758469490000},
                         Row{"1630577758.46949", 1630577758469490000},
                         Row{"1630577758.123456789", 1630577758123456789},
                         Row{"278.211490950", 278211490950},
                         Row{"0", 0},
                         Row{"7", 7000000000},
                         Row{".5", 500000000},
                         Row{"5.", 5000000000},
                         Row{"-1.25", -1250000000},
                         Row{"+1.25", 1250000000},
                         Row{"1.630577758469490051e+09", 1630577758469490051},
                         Row{"16305777584694E-4", 1630577758469400000},
                         Row{"1e-9", 1},
                         Row{"0.4e-9", 0},
                         Row{"0.5e-9", 1},
                         Row{"0.0000000014999", 1},
                         Row{"0.0000000015", 2},
                         Row{"1e-30", 0},
                         Row{"000000000000000000000000000001.0", 1000000000},
                         Row{"4000000000", 4000000000000000000}}) {
    CAPTURE(row.text);
    const auto stamp = parse_stamp(row.text);
    REQUIRE(stamp);
    CHECK(stamp->ns == row.ns);
  }
}

TEST_CASE("what is no stamp is refused") {
  for (const char* text :
       {"", ".", "-", "+-1", "1.2.3", "1,5", "abc", "1e", "1ee5", "e5", "nan", "inf", "4000000001",
        "99999999999999999999", "1e99", "1e1001", "- 1", "0x1"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_stamp(text));
  }
  CHECK_FALSE(make_stamp(1, 1'000'000'000));
  CHECK_FALSE(make_stamp(-1, 0));
  CHECK_FALSE(make_stamp(std::numeric_limits<std::int64_t>::max(), 0));
  CHECK(make_stamp(1690309710, 85582848)->ns == 1690309710085582848);
}

TEST_CASE("what is written reads back to the same value") {
  const unsigned seed = 7;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  for (int k = 0; k < 2000; ++k) {
    const SensorTime stamp{static_cast<std::int64_t>(random() % 8'000'000'000'000'000'000ULL) -
                           kMaxStamp_ns};
    std::string text;
    append_stamp(text, stamp);
    CAPTURE(text);
    const auto parsed = parse_stamp(text);
    REQUIRE(parsed);
    REQUIRE(parsed->ns == stamp.ns);

    const double value =
        std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 600) - 300);
    text.clear();
    append_number(text, value);
    REQUIRE(parse_double(text) == value);
  }
  std::string text;
  append_number(text, 0.1);
  append_number(text, -12);
  append_number(text, std::uint64_t{18446744073709551615ULL});
  CHECK(text == "0.1-1218446744073709551615");
}

TEST_CASE(
    "lines and fields are found under comments, blanks, carriage returns and a byte-order mark") {
  LineReader line("\xEF\xBB\xBF# head\r\n\r\n  a\tb  # tail\r\n#\nc", "f");
  REQUIRE(line.next_line());
  CHECK(line.line_number() == 3);
  CHECK(line.next_field() == "a");
  CHECK_FALSE(line.at_line_end());
  CHECK(line.next_field() == "b");
  CHECK(line.at_line_end());
  CHECK_FALSE(line.next_field());
  REQUIRE(line.next_line());
  CHECK(line.line_number() == 5);
  CHECK(line.next_field() == "c");
  CHECK_FALSE(line.next_line());
  CHECK_FALSE(line.next_field());
  CHECK(line.num_comment_lines() == 2);
}

TEST_CASE("between commas a field may be empty, which is no number") {
  LineReader line("1, ,3", "f.csv", LineReader::Separator::kCommas);
  REQUIRE(line.next_line());
  double value = 0;
  CHECK(line.read(value));
  CHECK_FALSE(line.read(value));
  CHECK(line.failure().value().message ==
        "f.csv:1: field 2, '', is not a finite number; correct or remove the line");
}

TEST_CASE("a message is one line, however the field looks") {
  const std::string text = "\n" + std::string(1000, '\x01');
  LineReader control(text, "f");
  REQUIRE(control.next_line());
  double value = 0;
  CHECK_FALSE(control.read(value));
  const std::string message = control.failure().value().message;
  CHECK(message.starts_with("f:2: field 1, '???"));
  CHECK(message.size() < 150);
}

}  // namespace
}  // namespace cloister
