#include "firmware_interface/ouster/packet_decoder.hpp"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "test/support/lidar_packet.hpp"

using namespace cloister;
using cloister::testing::Bytes;
using cloister::testing::encode;
using cloister::testing::LidarPacket;

TEST_CASE("a layout stands in the table where its profile says, and is found by its name") {
  for (const PacketLayout& layout : kPacketLayouts) {
    CHECK(&packet_layout(layout.profile) == &layout);
    CHECK(find_udp_profile(layout.name) == layout.profile);
  }
  CHECK_FALSE(find_udp_profile("RNG19").has_value());
}

TEST_CASE("packets have the sizes the manual states") {
  CHECK(packet_layout(UdpProfile::kLegacy).packet_bytes(64, 16) == 12608);
  CHECK(packet_layout(UdpProfile::kLegacy).packet_bytes(128, 16) == 24896);
  CHECK(packet_layout(UdpProfile::kRng15Rfl8Nir8).packet_bytes(128, 16) == 8448);
  CHECK(packet_layout(UdpProfile::kRng19Rfl8Sig16Nir16).packet_bytes(128, 16) == 24832);
  CHECK(packet_layout(UdpProfile::kRng19Rfl8Sig16Nir16Dual).packet_bytes(128, 16) == 33024);
  CHECK(packet_layout(UdpProfile::kFusaRng15Rfl8Nir8Dual).packet_bytes(128, 16) == 16640);
}

TEST_CASE("every field of every profile is read where an independent writer put it") {
  for (const PacketLayout& layout : kPacketLayouts) {
    for (const int num_beams : {16, 32, 64, 128}) {
      CAPTURE(std::string(layout.name));
      CAPTURE(num_beams);
      const bool is_15_bit = layout.range_mm.bytes == 2;
      const bool is_fusa = layout.profile == UdpProfile::kFusaRng15Rfl8Nir8Dual;
      LidarPacket packet;
      packet.profile = layout.name;
      packet.num_beams = num_beams;
      packet.frame_id = is_fusa ? 0xfedcba98 : 0xba98;
      packet.first_measurement_id = 1008;
      packet.first_stamp_ns = 1'697'084'629'342'350'336;
      packet.init_id = 0xabcdef;
      packet.serial_number = 992'219'000'042;
      packet.is_valid = [](int column) { return column != 3; };
      packet.range = [is_15_bit](int beam, int column) {
        return static_cast<std::uint32_t>(100 * beam + column + (is_15_bit ? 0 : 300'000));
      };
      const Bytes bytes = encode(packet);

      const PacketDecoder decoder(layout.profile, num_beams, 16);
      REQUIRE(bytes.size() == decoder.packet_bytes());
      const PacketHeader header = decoder.header(bytes);
      CHECK(header.is_lidar);
      CHECK(header.frame_id == packet.frame_id);
      CHECK(header.init_id == (layout.init_id.present() ? packet.init_id : 0));
      CHECK(header.serial_number == (layout.serial_number.present() ? packet.serial_number : 0));
      for (int i = 0; i < 16; ++i) {
        const ColumnHeader column = decoder.column(bytes, i);
        CHECK(column.measurement_id == 1008 + i);
        CHECK(column.valid == (i != 3));
        if (column.valid) CHECK(column.stamp.ns == 1'697'084'629'342'350'336 + 100'000 * i);
      }

      // Columns 2 and 5 of the packet go to columns 7 and 1 of a scan of eight.
      std::vector<std::uint32_t> ranges(static_cast<std::size_t>(num_beams) * 8, 5);
      const std::vector<int> from = {2, 5};
      const std::vector<int> to = {7, 1};
      decoder.copy_ranges(bytes, from, to, 8, ranges);
      for (int beam = 0; beam < num_beams; ++beam) {
        const std::uint32_t* row = ranges.data() + static_cast<std::ptrdiff_t>(beam) * 8;
        CHECK(row[7] == packet.range(beam, 2) * (is_15_bit ? 8 : 1));
        CHECK(row[1] == packet.range(beam, 5) * (is_15_bit ? 8 : 1));
        CHECK(row[0] == 5);
      }
    }
  }
}

TEST_CASE("bits above the range are not part of it") {
  for (const PacketLayout& layout : kPacketLayouts) {
    CAPTURE(std::string(layout.name));
    LidarPacket packet;
    packet.profile = layout.name;
    packet.range = [](int beam, int) { return beam == 0 ? 0x80100000U | 0x8000U : 0xffffffffU; };
    const Bytes bytes = encode(packet);
    const PacketDecoder decoder(layout.profile, 16, 16);
    std::vector<std::uint32_t> ranges(16);
    const std::vector<int> first = {0};
    decoder.copy_ranges(bytes, first, first, 1, ranges);
    const bool is_15_bit = layout.range_mm.bytes == 2;
    CHECK(ranges[0] == (is_15_bit ? 0 : 0x8000));
    CHECK(ranges[1] == (is_15_bit                               ? 0x7fff * 8
                        : layout.profile == UdpProfile::kLegacy ? 0xfffff
                                                                : 0x7ffff));
  }
}

TEST_CASE("a column is invalid when its stamp is impossible or its frame is another") {
  const PacketDecoder decoder(UdpProfile::kLegacy, 16, 16);
  LidarPacket packet;
  packet.first_stamp_ns = (1ULL << 62) - 1;
  packet.column_step_ns = 1;
  Bytes bytes = encode(packet);
  CHECK(decoder.column(bytes, 0).valid);
  CHECK_FALSE(decoder.column(bytes, 1).valid);
  CHECK(decoder.column(bytes, 1).stamp.ns == 0);

  bytes = encode(LidarPacket{});
  const std::size_t second_frame_id = 16 + 12 * 16 + 4 + 10;
  bytes[second_frame_id] = std::byte{1};
  CHECK(decoder.column(bytes, 0).valid);
  CHECK_FALSE(decoder.column(bytes, 1).valid);
}
