#include "bench/simulate/pcap_record.hpp"

#include <algorithm>
#include <array>

namespace cloister {

namespace {

constexpr std::size_t kMtu = 1500;
constexpr std::size_t kIpHeader = 20;
constexpr std::size_t kFragment = (kMtu - kIpHeader) / 8 * 8;
constexpr std::size_t kEthernetHeader = 14;
constexpr std::uint8_t kUdp = 17;

void put_le32(std::uint32_t value, std::vector<std::uint8_t>* out) {
  for (int byte = 0; byte < 4; ++byte)
    out->push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
}

void put_le16(std::uint16_t value, std::vector<std::uint8_t>* out) {
  out->push_back(static_cast<std::uint8_t>(value));
  out->push_back(static_cast<std::uint8_t>(value >> 8));
}

template <std::size_t N>
void set_be16(std::array<std::uint8_t, N>* bytes, std::size_t at, std::uint32_t value) {
  (*bytes)[at] = static_cast<std::uint8_t>(value >> 8);
  (*bytes)[at + 1] = static_cast<std::uint8_t>(value);
}

template <std::size_t N>
void set_be32(std::array<std::uint8_t, N>* bytes, std::size_t at, std::uint32_t value) {
  set_be16(bytes, at, value >> 16);
  set_be16(bytes, at + 2, value & 0xFFFF);
}

std::array<std::uint8_t, 8> udp_header(const UdpFlow& flow, std::span<const std::uint8_t> payload) {
  const auto length = static_cast<std::uint32_t>(payload.size() + 8);
  std::array<std::uint8_t, 8> header{};
  set_be16(&header, 0, flow.source_port);
  set_be16(&header, 2, flow.destination_port);
  set_be16(&header, 4, length);
  std::array<std::uint8_t, 12> pseudo{};
  set_be32(&pseudo, 0, flow.source_ip);
  set_be32(&pseudo, 4, flow.destination_ip);
  pseudo[9] = kUdp;
  set_be16(&pseudo, 10, length);
  const std::uint16_t sum = finish_checksum(
      add_to_checksum(payload, add_to_checksum(header, add_to_checksum(pseudo, 0))));
  set_be16(&header, 6, sum == 0 ? 0xFFFF : sum);  // zero would mean "no checksum" (RFC 768)
  return header;
}

std::array<std::uint8_t, kIpHeader> ip_header(const UdpFlow& flow, std::uint16_t ip_id,
                                              std::size_t offset, std::size_t length,
                                              bool more_fragments) {
  std::array<std::uint8_t, kIpHeader> header{};
  header[0] = 0x45;
  set_be16(&header, 2, static_cast<std::uint32_t>(kIpHeader + length));
  set_be16(&header, 4, ip_id);
  set_be16(&header, 6, static_cast<std::uint32_t>(offset / 8) | (more_fragments ? 0x2000U : 0U));
  header[8] = 64;  // time to live
  header[9] = kUdp;
  set_be32(&header, 12, flow.source_ip);
  set_be32(&header, 16, flow.destination_ip);
  set_be16(&header, 10, finish_checksum(add_to_checksum(header, 0)));
  return header;
}

}  // namespace

std::uint32_t add_to_checksum(std::span<const std::uint8_t> bytes, std::uint32_t sum) {
  for (std::size_t k = 0; k + 1 < bytes.size(); k += 2) {
    sum += static_cast<std::uint32_t>(bytes[k] << 8 | bytes[k + 1]);
  }
  if (bytes.size() % 2 == 1) sum += static_cast<std::uint32_t>(bytes.back()) << 8;
  return (sum & 0xFFFF) + (sum >> 16);
}

std::uint16_t finish_checksum(std::uint32_t sum) {
  while (sum >> 16 != 0) sum = (sum & 0xFFFF) + (sum >> 16);
  return static_cast<std::uint16_t>(~sum);
}

void append_pcap_header(std::vector<std::uint8_t>* out) {
  constexpr std::uint32_t kMagicMicroseconds = 0xA1B2C3D4;
  constexpr std::uint32_t kSnapLength = 262'144;
  constexpr std::uint32_t kEthernet = 1;
  put_le32(kMagicMicroseconds, out);
  put_le16(2, out);
  put_le16(4, out);
  put_le32(0, out);
  put_le32(0, out);
  put_le32(kSnapLength, out);
  put_le32(kEthernet, out);
}

void append_udp_datagram(const UdpFlow& flow, SensorTime stamp, std::uint16_t ip_id,
                         std::span<const std::uint8_t> payload, std::vector<std::uint8_t>* out) {
  constexpr std::array<std::uint8_t, kEthernetHeader> kFrame = {
      0x02, 0x00, 0x00, 0x00, 0x00, 0x01, 0x02, 0x00, 0x00, 0x00, 0x00, 0x02, 0x08, 0x00};
  const std::array<std::uint8_t, 8> udp = udp_header(flow, payload);
  const std::size_t total = udp.size() + payload.size();
  for (std::size_t offset = 0; offset < total; offset += kFragment) {
    const std::size_t length = std::min(kFragment, total - offset);
    const auto frame_bytes = static_cast<std::uint32_t>(kEthernetHeader + kIpHeader + length);
    put_le32(static_cast<std::uint32_t>(stamp.ns / 1'000'000'000), out);
    put_le32(static_cast<std::uint32_t>(stamp.ns / 1'000 % 1'000'000), out);
    put_le32(frame_bytes, out);
    put_le32(frame_bytes, out);
    out->insert(out->end(), kFrame.begin(), kFrame.end());
    const auto ip = ip_header(flow, ip_id, offset, length, offset + length < total);
    out->insert(out->end(), ip.begin(), ip.end());
    // The UDP header opens the first fragment; from there on fragments hold payload only.
    const std::size_t header_part = offset == 0 ? udp.size() : 0;
    if (header_part > 0) out->insert(out->end(), udp.begin(), udp.end());
    const auto first =
        payload.begin() + static_cast<std::ptrdiff_t>(offset + header_part - udp.size());
    out->insert(out->end(), first, first + static_cast<std::ptrdiff_t>(length - header_part));
  }
}

}  // namespace cloister
