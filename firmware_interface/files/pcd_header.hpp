#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "mapping/core/result.hpp"

namespace cloister {

/// How a PCD file stores one coordinate.
struct PcdField {
  char type = 'F';         ///< I, U or F
  std::size_t size = 4;    ///< bytes: 1, 2, 4 or 8
  std::size_t offset = 0;  ///< bytes from the start of a point's record
  std::size_t column = 0;  ///< values before it in an ascii line
};

/// What a PCD header says, checked.
struct PcdHeader {
  enum class Data { kAscii, kBinary, kCompressed };

  std::array<PcdField, 3> xyz;
  std::size_t record_bytes = 0;  ///< of one point, all fields; at most kMaxPcdRecordBytes
  std::size_t num_columns = 0;   ///< values of one ascii line
  std::size_t num_points = 0;
  Data data = Data::kAscii;
  std::size_t body_begin = 0;  ///< byte that follows the header
  std::size_t num_lines = 0;   ///< lines of the header
};

inline constexpr std::size_t kMaxPcdRecordBytes = std::size_t{1} << 20;

/// Reads the header of a PCD file, up to and with its DATA line.
/// @return kInput with file:line at the first line that is wrong
[[nodiscard]] Result<PcdHeader> read_pcd_header(std::string_view bytes, std::string_view file_name);

}  // namespace cloister
