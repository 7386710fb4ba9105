#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace cloister {

static_assert(std::endian::native == std::endian::little, "packet fields are loaded as they lie");

/// How the sensor lays out a lidar packet (`udp_profile_lidar` of its metadata).
enum class UdpProfile {
  kLegacy,
  kRng15Rfl8Nir8,
  kRng19Rfl8Sig16Nir16,
  kRng19Rfl8Sig16Nir16Dual,
  kFusaRng15Rfl8Nir8Dual,
};

/// One little-endian number inside a packet: `(word(bytes at offset) & mask) << shift`.
struct PacketField {
  int offset = 0;  ///< bytes from the start of the packet, column or pixel it belongs to
  int bytes = 0;   ///< width of the word that is loaded, 1 to 8; 0: the profile has no such field
  std::uint64_t mask = 0;
  int shift = 0;

  [[nodiscard]] constexpr bool present() const { return bytes != 0; }
  [[nodiscard]] std::uint64_t load(const std::byte* start) const {
    std::uint64_t word = 0;
    std::memcpy(&word, start + offset, static_cast<std::size_t>(bytes));
    return (word & mask) << shift;
  }
};

/// A packet is a header, columns of equal size, and a footer; a column is a header, one pixel per
/// beam, and a footer.
struct PacketLayout {
  UdpProfile profile;
  std::string_view name;  ///< as the metadata spells it
  int packet_header_bytes;
  int packet_footer_bytes;
  int column_header_bytes;
  int column_footer_bytes;
  int pixel_bytes;

  // From the start of the packet.
  // LEGACY has no packet header: the frame id is that of the first column.
  PacketField packet_type;  ///< 1 for a lidar packet
  PacketField frame_id;
  PacketField init_id;
  PacketField serial_number;

  // From the start of a column.
  PacketField timestamp_ns;
  PacketField measurement_id;
  PacketField column_frame_id;  ///< LEGACY only: each column repeats it

  // From the start of the column, or of its footer when it has one.
  // The column is valid when all bits of the mask are set.
  PacketField status;

  // From the start of a pixel. Dual profiles: the first return, the stronger one.
  PacketField range_mm;
  PacketField reflectivity;

  [[nodiscard]] constexpr int column_bytes(int num_beams) const {
    return column_header_bytes + num_beams * pixel_bytes + column_footer_bytes;
  }
  [[nodiscard]] constexpr int packet_bytes(int num_beams, int columns_per_packet) const {
    return packet_header_bytes + columns_per_packet * column_bytes(num_beams) + packet_footer_bytes;
  }
  /// Start of the status word's base within a column.
  [[nodiscard]] constexpr int status_base(int num_beams) const {
    return column_footer_bytes == 0 ? 0 : column_header_bytes + num_beams * pixel_bytes;
  }
};

/// The profiles this decoder knows, from the sensor's firmware manual ("Lidar data packet format",
/// legacy and configurable). Ranges are the low 15, 19 or 20 bits; sensors do set bits above them
/// on pixels without a return. A 15-bit range counts steps of 8 mm.
inline constexpr std::array<PacketLayout, 5> kPacketLayouts = {{
    {.profile = UdpProfile::kLegacy,
     .name = "LEGACY",
     .packet_header_bytes = 0,
     .packet_footer_bytes = 0,
     .column_header_bytes = 16,
     .column_footer_bytes = 4,
     .pixel_bytes = 12,
     .packet_type = {},
     .frame_id = {10, 2, 0xffff},
     .init_id = {},
     .serial_number = {},
     .timestamp_ns = {0, 8, ~0ULL},
     .measurement_id = {8, 2, 0xffff},
     .column_frame_id = {10, 2, 0xffff},
     .status = {0, 4, 0xffffffff},
     .range_mm = {0, 4, 0xfffff},
     .reflectivity = {4, 1, 0xff}},
    {.profile = UdpProfile::kRng15Rfl8Nir8,
     .name = "RNG15_RFL8_NIR8",
     .packet_header_bytes = 32,
     .packet_footer_bytes = 32,
     .column_header_bytes = 12,
     .column_footer_bytes = 0,
     .pixel_bytes = 4,
     .packet_type = {0, 2, 0xffff},
     .frame_id = {2, 2, 0xffff},
     .init_id = {4, 3, 0xffffff},
     .serial_number = {7, 5, 0xffffffffff},
     .timestamp_ns = {0, 8, ~0ULL},
     .measurement_id = {8, 2, 0xffff},
     .column_frame_id = {},
     .status = {10, 2, 1},
     .range_mm = {0, 2, 0x7fff, 3},
     .reflectivity = {2, 1, 0xff}},
    {.profile = UdpProfile::kRng19Rfl8Sig16Nir16,
     .name = "RNG19_RFL8_SIG16_NIR16",
     .packet_header_bytes = 32,
     .packet_footer_bytes = 32,
     .column_header_bytes = 12,
     .column_footer_bytes = 0,
     .pixel_bytes = 12,
     .packet_type = {0, 2, 0xffff},
     .frame_id = {2, 2, 0xffff},
     .init_id = {4, 3, 0xffffff},
     .serial_number = {7, 5, 0xffffffffff},
     .timestamp_ns = {0, 8, ~0ULL},
     .measurement_id = {8, 2, 0xffff},
     .column_frame_id = {},
     .status = {10, 2, 1},
     .range_mm = {0, 4, 0x7ffff},
     .reflectivity = {4, 1, 0xff}},
    {.profile = UdpProfile::kRng19Rfl8Sig16Nir16Dual,
     .name = "RNG19_RFL8_SIG16_NIR16_DUAL",
     .packet_header_bytes = 32,
     .packet_footer_bytes = 32,
     .column_header_bytes = 12,
     .column_footer_bytes = 0,
     .pixel_bytes = 16,
     .packet_type = {0, 2, 0xffff},
     .frame_id = {2, 2, 0xffff},
     .init_id = {4, 3, 0xffffff},
     .serial_number = {7, 5, 0xffffffffff},
     .timestamp_ns = {0, 8, ~0ULL},
     .measurement_id = {8, 2, 0xffff},
     .column_frame_id = {},
     .status = {10, 2, 1},
     .range_mm = {0, 4, 0x7ffff},
     .reflectivity = {3, 1, 0xff}},
    {.profile = UdpProfile::kFusaRng15Rfl8Nir8Dual,
     .name = "FUSA_RNG15_RFL8_NIR8_DUAL",
     .packet_header_bytes = 32,
     .packet_footer_bytes = 32,
     .column_header_bytes = 12,
     .column_footer_bytes = 0,
     .pixel_bytes = 8,
     .packet_type = {0, 1, 0xff},
     .frame_id = {4, 4, 0xffffffff},
     .init_id = {1, 3, 0xffffff},
     .serial_number = {11, 5, 0xffffffffff},
     .timestamp_ns = {0, 8, ~0ULL},
     .measurement_id = {8, 2, 0xffff},
     .column_frame_id = {},
     .status = {10, 2, 1},
     .range_mm = {0, 2, 0x7fff, 3},
     .reflectivity = {2, 1, 0xff}},
}};

[[nodiscard]] constexpr const PacketLayout& packet_layout(UdpProfile profile) {
  return kPacketLayouts[static_cast<std::size_t>(profile)];
}

/// The profile that the metadata calls `name`, or nothing.
[[nodiscard]] constexpr std::optional<UdpProfile> find_udp_profile(std::string_view name) {
  for (const PacketLayout& layout : kPacketLayouts) {
    if (layout.name == name) return layout.profile;
  }
  return std::nullopt;
}

/// A packet of the sensor's inertial unit (legacy IMU profile), which may come to the lidar's port.
inline constexpr int kImuPacketBytes = 48;

}  // namespace cloister
