#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware_interface/ouster/packet_layout.hpp"
#include "mapping/core/time.hpp"

namespace cloister {

/// What a lidar packet says about itself. Fields that the profile does not have are 0.
struct PacketHeader {
  bool is_lidar = true;
  std::uint32_t frame_id = 0;
  std::uint32_t init_id = 0;
  std::uint64_t serial_number = 0;
};

/// What one column of a packet says about itself.
struct ColumnHeader {
  SensorTime stamp;
  /// The column's place in the revolution; not checked against the lidar mode.
  int measurement_id = 0;
  /// Marked valid by the sensor, with a possible stamp and the packet's own frame id.
  bool valid = false;
};

/// Reads the fields of lidar packets of one profile and size.
/// Threads: immutable, so any. Real-time: no allocation. Bounds: the caller checks that the payload
/// has `packet_bytes()` bytes; nothing else in the packet can make a call read outside it.
class PacketDecoder {
 public:
  PacketDecoder(UdpProfile profile, int num_beams, int columns_per_packet);

  [[nodiscard]] const PacketLayout& layout() const { return layout_; }
  [[nodiscard]] std::size_t packet_bytes() const { return packet_bytes_; }
  [[nodiscard]] int columns_per_packet() const { return columns_per_packet_; }

  [[nodiscard]] PacketHeader header(std::span<const std::byte> packet) const;
  [[nodiscard]] ColumnHeader column(std::span<const std::byte> packet, int column_idx) const;

  /// Copies the ranges of some of a packet's columns into an organised scan.
  /// @param packet_columns  which columns of the packet, each in [0, columns_per_packet)
  /// @param scan_columns    where each of them goes, same length, each in [0, num_scan_columns)
  /// @param ranges_mm       [num_beams x num_scan_columns], row-major; 0 = no return
  void copy_ranges(std::span<const std::byte> packet, std::span<const int> packet_columns,
                   std::span<const int> scan_columns, int num_scan_columns,
                   std::span<std::uint32_t> ranges_mm) const;

 private:
  [[nodiscard]] const std::byte* column_start(std::span<const std::byte> packet,
                                              int column_idx) const {
    return packet.data() + layout_.packet_header_bytes + column_idx * column_bytes_;
  }

  const PacketLayout& layout_;
  int num_beams_;
  int columns_per_packet_;
  int column_bytes_;
  std::size_t packet_bytes_;
};

}  // namespace cloister
