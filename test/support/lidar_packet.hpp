#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "test/support/capture_builder.hpp"

namespace cloister::testing {

/// One lidar packet to be written, field by field in the order the sensor's manual lists them. Shares nothing with the
/// decoder: where one of the two is wrong, they disagree.
struct LidarPacket {
  std::string profile = "LEGACY";
  int num_beams = 16;
  int num_columns = 16;  ///< in this packet
  std::uint32_t frame_id = 0;
  int first_measurement_id = 0;
  std::uint64_t first_stamp_ns = 0;
  std::uint64_t column_step_ns = 100'000;
  std::uint32_t init_id = 0;
  std::uint64_t serial_number = 0;
  std::function<bool(int column)> is_valid = [](int) { return true; };
  /// Range of a beam in the packet's column: millimetres, or steps of 8 mm for the 15-bit profiles. Bits above the
  /// range's own are written as they are where the profile has room for them.
  std::function<std::uint32_t(int beam, int column)> range = [](int, int) { return 1000U; };
};

inline Bytes encode(const LidarPacket& packet) {
  Bytes out;
  const bool is_legacy = packet.profile == "LEGACY";
  if (packet.profile == "FUSA_RNG15_RFL8_NIR8_DUAL") {
    put_le(out, 1, 1);               // packet type
    put_le(out, packet.init_id, 3);  // initialisation id
    put_le(out, packet.frame_id, 4);
    put_le(out, 0, 3);
    put_le(out, packet.serial_number, 5);
    put_le(out, 0, 8);
    put_le(out, 0, 8);
  } else if (!is_legacy) {
    put_le(out, 1, 2);  // packet type
    put_le(out, packet.frame_id & 0xffff, 2);
    put_le(out, packet.init_id, 3);
    put_le(out, packet.serial_number, 5);
    put_le(out, 0, 8);
    put_le(out, 0, 8);
    put_le(out, 0, 4);
  }
  for (int column = 0; column < packet.num_columns; ++column) {
    const int measurement_id = packet.first_measurement_id + column;
    put_le(out, packet.first_stamp_ns + packet.column_step_ns * static_cast<unsigned>(column), 8);
    put_le(out, static_cast<std::uint64_t>(measurement_id), 2);
    if (is_legacy) {
      put_le(out, packet.frame_id & 0xffff, 2);
      put_le(out, static_cast<std::uint64_t>(measurement_id) * 88, 4);  // encoder count
    } else {
      put_le(out, packet.is_valid(column) ? 1 : 0, 2);
    }
    for (int beam = 0; beam < packet.num_beams; ++beam) {
      const std::uint32_t range = packet.range(beam, column);
      if (is_legacy) {
        put_le(out, range, 4);
        put_le(out, 11, 2);  // reflectivity
        put_le(out, 22, 2);  // signal
        put_le(out, 33, 2);  // near infrared
        put_le(out, 0, 2);
      } else if (packet.profile == "RNG15_RFL8_NIR8") {
        put_le(out, range, 2);
        put_le(out, 11, 1);
        put_le(out, 33, 1);
      } else if (packet.profile == "RNG19_RFL8_SIG16_NIR16") {
        put_le(out, range, 4);
        put_le(out, 11, 1);
        put_le(out, 0, 1);
        put_le(out, 22, 2);
        put_le(out, 33, 2);
        put_le(out, 0, 2);
      } else if (packet.profile == "RNG19_RFL8_SIG16_NIR16_DUAL") {
        put_le(out, (range & 0xffffff) | (11U << 24), 4);  // first return and its reflectivity
        put_le(out, 777U | (44U << 24), 4);                // second return and its reflectivity
        put_le(out, 22, 2);
        put_le(out, 55, 2);
        put_le(out, 33, 2);
        put_le(out, 0, 2);
      } else {
        put_le(out, range, 2);
        put_le(out, 11, 1);
        put_le(out, 33, 1);
        put_le(out, 99, 2);  // second return
        put_le(out, 44, 1);
        put_le(out, 0, 1);
      }
    }
    if (is_legacy) put_le(out, packet.is_valid(column) ? 0xffffffff : 0, 4);
  }
  if (!is_legacy) out.resize(out.size() + 32);
  return out;
}

}  // namespace cloister::testing
