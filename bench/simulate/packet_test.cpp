#include <array>
#include <cstring>
#include <map>

#include <doctest/doctest.h>

#include "bench/simulate/legacy_packet.hpp"
#include "bench/simulate/pcap_record.hpp"

namespace cloister {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::uint64_t little(const Bytes& bytes, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int k = size - 1; k >= 0; --k) value = value << 8 | bytes[at + static_cast<std::size_t>(k)];
  return value;
}

std::uint32_t big16(const std::uint8_t* bytes) {
  return static_cast<std::uint32_t>(bytes[0] << 8 | bytes[1]);
}

TEST_CASE("a LEGACY packet has its fields where the manual puts them") {
  std::vector<std::vector<PixelReturn>> pixels(kColumnsPerPacket, std::vector<PixelReturn>(64));
  std::vector<ColumnReturns> columns(kColumnsPerPacket);
  for (std::uint16_t c = 0; c < kColumnsPerPacket; ++c) {
    for (std::uint32_t b = 0; b < 64; ++b) {
      pixels[c][b] = {100'000U * (b % 10) + c, static_cast<std::uint16_t>(b + 1),
                      static_cast<std::uint16_t>(1000 + b), static_cast<std::uint16_t>(2000 + c)};
    }
    columns[c] = {1'700'000'000'123'456'789ULL + c, static_cast<std::uint16_t>(512 + c), 65'535,
                  88U * (512U + c), pixels[c]};
  }
  Bytes packet;
  append_legacy_packet(columns, &packet);

  REQUIRE(packet.size() == 12'608);
  REQUIRE(packet.size() == legacy_packet_bytes(64));
  constexpr std::size_t kColumnBytes = 788;
  for (std::size_t c = 0; c < kColumnsPerPacket; ++c) {
    const std::size_t at = c * kColumnBytes;
    CHECK(little(packet, at, 8) == 1'700'000'000'123'456'789ULL + c);
    CHECK(little(packet, at + 8, 2) == 512 + c);
    CHECK(little(packet, at + 10, 2) == 65'535);
    CHECK(little(packet, at + 12, 4) == 88 * (512 + c));
    CHECK(little(packet, at + 16, 4) == c);
    CHECK(little(packet, at + 16 + 12 * 9, 4) == 900'000 + c);
    CHECK(little(packet, at + 16 + 12 * 63 + 4, 2) == 64);
    CHECK(little(packet, at + 16 + 12 * 63 + 6, 2) == 1063);
    CHECK(little(packet, at + 16 + 12 * 63 + 8, 2) == 2000 + c);
    CHECK(little(packet, at + 16 + 12 * 63 + 10, 2) == 0);
    CHECK(little(packet, at + 784, 4) == 0xFFFFFFFF);
  }
}

TEST_CASE("the internet checksum of the example in RFC 1071 is right") {
  const std::array<std::uint8_t, 8> bytes = {0x00, 0x01, 0xf2, 0x03, 0xf4, 0xf5, 0xf6, 0xf7};
  CHECK(finish_checksum(add_to_checksum(bytes, 0)) == static_cast<std::uint16_t>(~0xddf2));
}

TEST_CASE("a checksum over an odd number of bytes counts the last one as the high half") {
  const std::array<std::uint8_t, 3> bytes = {0x12, 0x34, 0x56};
  CHECK(finish_checksum(add_to_checksum(bytes, 0)) ==
        static_cast<std::uint16_t>(~(0x1234 + 0x5600)));
}

TEST_CASE("fragments of a datagram are valid IPv4 and join to what was sent") {
  Bytes payload(12'608);
  for (std::size_t k = 0; k < payload.size(); ++k)
    payload[k] = static_cast<std::uint8_t>(k * 31 + k / 256);
  Bytes records;
  append_udp_datagram(UdpFlow{}, SensorTime{1'700'000'001'234'567'890}, 4711, payload, &records);

  Bytes datagram;
  int fragments = 0;
  for (std::size_t at = 0; at < records.size(); ++fragments) {
    CHECK(little(records, at, 4) == 1'700'000'001);
    CHECK(little(records, at + 4, 4) == 234'567);
    const std::size_t length = little(records, at + 8, 4);
    CHECK(little(records, at + 12, 4) == length);
    CHECK(length <= 14 + 1500);
    const std::uint8_t* frame = records.data() + at + 16;
    CHECK(big16(frame + 12) == 0x0800);
    const std::uint8_t* ip = frame + 14;
    CHECK(ip[0] == 0x45);
    CHECK(big16(ip + 2) == length - 14);
    CHECK(big16(ip + 4) == 4711);
    CHECK(finish_checksum(add_to_checksum({ip, 20}, 0)) == 0);
    CHECK((big16(ip + 6) & 0x1FFF) * 8 == datagram.size());
    const bool is_last = at + 16 + length == records.size();
    CHECK(((big16(ip + 6) & 0x2000) == 0) == is_last);
    datagram.insert(datagram.end(), ip + 20, frame + length);
    at += 16 + length;
  }
  CHECK(fragments == 9);
  REQUIRE(datagram.size() == payload.size() + 8);
  CHECK(big16(datagram.data()) == 7502);
  CHECK(big16(datagram.data() + 2) == 7502);
  CHECK(big16(datagram.data() + 4) == datagram.size());
  CHECK(std::equal(payload.begin(), payload.end(), datagram.begin() + 8));
  const std::array<std::uint8_t, 12> pseudo = {192, 168, 10, 123, 192,         168,
                                               10,  1,   0,  17,  datagram[4], datagram[5]};
  CHECK(finish_checksum(add_to_checksum(datagram, add_to_checksum(pseudo, 0))) == 0);
}

TEST_CASE("a datagram that fits one frame is not fragmented") {
  const Bytes payload(48, 7);
  Bytes records;
  append_udp_datagram(UdpFlow{}, SensorTime{0}, 1, payload, &records);
  REQUIRE(records.size() == 16 + 14 + 20 + 8 + 48);
  CHECK(big16(records.data() + 16 + 14 + 6) == 0);
}

TEST_CASE("the pcap header names classic microsecond Ethernet captures") {
  Bytes header;
  append_pcap_header(&header);
  REQUIRE(header.size() == 24);
  CHECK(little(header, 0, 4) == 0xA1B2C3D4);
  CHECK(little(header, 4, 2) == 2);
  CHECK(little(header, 6, 2) == 4);
  CHECK(little(header, 20, 4) == 1);
}

}  // namespace
}  // namespace cloister
