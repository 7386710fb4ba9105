#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cloister {

/// What one beam of one column measured.
struct PixelReturn {
  std::uint32_t range_mm = 0;  ///< 0 = nothing came back
  std::uint16_t reflectivity = 0;
  std::uint16_t signal = 0;
  std::uint16_t near_ir = 0;
};

/// One column, all beams fired at one instant.
struct ColumnReturns {
  std::uint64_t stamp_ns = 0;
  std::uint16_t measurement_id = 0;  ///< 0 .. columns per revolution - 1
  std::uint16_t frame_id = 0;        ///< counts revolutions, wraps
  std::uint32_t encoder_ticks = 0;   ///< 90,112 to the revolution
  std::span<const PixelReturn> pixels;
};

inline constexpr int kColumnsPerPacket = 16;
inline constexpr std::uint32_t kEncoderTicksPerRevolution = 90'112;

/// Bytes of one packet: sixteen columns of a 16-byte header, 12 bytes per beam and a 4-byte status
/// word.
[[nodiscard]] constexpr std::size_t legacy_packet_bytes(int beams) {
  return static_cast<std::size_t>(kColumnsPerPacket) *
         (16 + 12 * static_cast<std::size_t>(beams) + 4);
}

/// Encodes a packet in the sensor's LEGACY profile (Ouster software user manual 2.x, "Lidar data
/// packet format"), little endian, every column marked valid.
/// @param columns exactly kColumnsPerPacket, all with the same number of pixels
void append_legacy_packet(std::span<const ColumnReturns> columns, std::vector<std::uint8_t>* out);

}  // namespace cloister
